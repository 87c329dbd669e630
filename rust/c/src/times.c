/* SPDX-License-Identifier: Apache-2.0 */
/* Arithmetic with times and tags, and their texts. */

#include "lf_internal.h"

instant_t lf_time_physical_elapsed(void)
{
	return lf_time_physical() - lf_time_start();
}

instant_t lf_time_add(instant_t a, interval_t b)
{
	instant_t sum;

	if (a == NEVER || b == NEVER) {
		return NEVER;
	}
	if (a == FOREVER || b == FOREVER) {
		return FOREVER;
	}
	if (__builtin_add_overflow(a, b, &sum)) {
		return b > 0 ? FOREVER : NEVER;
	}
	return sum;
}

instant_t lf_time_subtract(instant_t a, interval_t b)
{
	instant_t difference;

	if (a == NEVER || b == FOREVER) {
		return NEVER;
	}
	if (a == FOREVER || b == NEVER) {
		return FOREVER;
	}
	if (__builtin_sub_overflow(a, b, &difference)) {
		return b < 0 ? FOREVER : NEVER;
	}
	return difference;
}

int lf_tag_compare(tag_t a, tag_t b)
{
	if (a.time != b.time) {
		return a.time < b.time ? -1 : 1;
	}
	return (a.microstep > b.microstep) - (a.microstep < b.microstep);
}

tag_t lf_tag_min(tag_t a, tag_t b)
{
	return lf_tag_compare(a, b) < 0 ? a : b;
}

tag_t lf_tag_max(tag_t a, tag_t b)
{
	return lf_tag_compare(a, b) < 0 ? b : a;
}

tag_t lf_tag_add(tag_t a, tag_t b)
{
	tag_t sum = {.time = lf_time_add(a.time, b.time), .microstep = 0};
	microstep_t before = b.time > 0 ? 0 : a.microstep;

	if (sum.time == NEVER) {
		return NEVER_TAG;
	}
	if (sum.time == FOREVER || __builtin_add_overflow(before, b.microstep, &sum.microstep)) {
		return FOREVER_TAG;
	}
	return sum;
}

tag_t lf_delay_tag(tag_t tag, interval_t interval)
{
	if (tag.time == NEVER || interval < 0) {
		return tag;
	}
	if (tag.time >= FOREVER - interval) {
		return FOREVER_TAG;
	}
	if (interval == 0) {
		tag.microstep++;
	} else {
		tag.time += interval;
		tag.microstep = 0;
	}
	return tag;
}

tag_t lf_delay_strict(tag_t tag, interval_t interval)
{
	tag_t delayed = lf_delay_tag(tag, interval);

	if (tag.time == NEVER || interval < 0) {
		return delayed;
	}
	return interval == 0 ? tag : lf_tag_latest_earlier(delayed);
}

tag_t lf_tag_latest_earlier(tag_t tag)
{
	if (lf_tag_compare(tag, NEVER_TAG) == 0 || lf_tag_compare(tag, FOREVER_TAG) == 0) {
		return tag;
	}
	if (tag.microstep == 0) {
		tag.time--;
		tag.microstep = FOREVER_MICROSTEP;
	} else {
		tag.microstep--;
	}
	return tag;
}

size_t lf_comma_separated_time(char *buffer, instant_t time)
{
	char digits[24];
	int length = snprintf(digits, sizeof(digits), "%" PRId64, time);
	size_t written = 0;

	for (int i = 0; i < length; i++) {
		int behind = length - i;
		bool is_first = i == 0 || digits[i - 1] == '-';
		if (behind % 3 == 0 && !is_first) {
			buffer[written++] = ',';
		}
		buffer[written++] = digits[i];
	}
	buffer[written] = '\0';
	return written;
}

/* The parts of a time's text, and the minimum count for which a unit is printed. */
static const struct {
	interval_t unit;
	const char *name;
} PARTS[] = {
	{WEEKS(1), "weeks"}, {DAYS(1), "d"}, {HOURS(1), "h"}, {MINUTES(1), "min"}, {SECONDS(1), "s"},
};

static size_t write_part(char *buffer, bool is_first, instant_t amount, const char *unit)
{
	size_t written = 0;

	if (!is_first) {
		buffer[written++] = ',';
		buffer[written++] = ' ';
	}
	written += lf_comma_separated_time(&buffer[written], amount);
	buffer[written++] = ' ';
	strcpy(&buffer[written], unit);
	return written + strlen(unit);
}

size_t lf_readable_time(char *buffer, instant_t time)
{
	size_t written = 0;

	if (time <= 0) {
		strcpy(buffer, "0");
		return 1;
	}
	for (size_t i = 0; i < sizeof(PARTS) / sizeof(PARTS[0]); i++) {
		if (time > PARTS[i].unit) {
			written += write_part(&buffer[written], written == 0, time / PARTS[i].unit, PARTS[i].name);
			time %= PARTS[i].unit;
		}
	}
	if (time % MSEC(1) == 0 && time > 0) {
		written += write_part(&buffer[written], written == 0, time / MSEC(1), "ms");
	} else if (time % USEC(1) == 0 && time > 0) {
		written += write_part(&buffer[written], written == 0, time / USEC(1), "us");
	} else if (time > 0) {
		written += write_part(&buffer[written], written == 0, time, "ns");
	}
	return written;
}

static const struct {
	const char *name;
	bool is_prefix;
	interval_t unit;
} UNITS[] = {
	{"nsec", true, NSEC(1)},  {"ns", false, NSEC(1)},  {"usec", true, USEC(1)}, {"us", false, USEC(1)},
	{"msec", true, MSEC(1)},  {"ms", false, MSEC(1)},  {"sec", true, SEC(1)},   {"s", false, SEC(1)},
	{"min", true, MINUTE(1)}, {"hour", true, HOUR(1)}, {"day", true, DAY(1)},   {"week", true, WEEK(1)},
};

int lf_time_parse(const char *number, const char *unit, interval_t *result)
{
	char *end;
	long value = strtol(number, &end, 10);

	if (end == number || *end != '\0') {
		return -1;
	}
	for (size_t i = 0; i < sizeof(UNITS) / sizeof(UNITS[0]); i++) {
		bool matches = UNITS[i].is_prefix ? strncmp(unit, UNITS[i].name, strlen(UNITS[i].name)) == 0
						  : strcmp(unit, UNITS[i].name) == 0;
		if (matches) {
			*result = value * UNITS[i].unit;
			return 0;
		}
	}
	return -2;
}
