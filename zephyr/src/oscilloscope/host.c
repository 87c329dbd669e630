/* SPDX-License-Identifier: Apache-2.0 */
/* The computer's side: its clock, the recording in memory, and its files. */

#include "host.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nsi_hws_models_if.h>
#include <nsi_tasks.h>
#include <nsi_tracing.h>

/* The maximum number of changes in a recording: 160 MB. */
#define CHANGES_MAX 10000000U

struct change {
	int64_t time;
	uint32_t pin;
	bool active;
};

struct pin {
	char *name;
	/* Whether it has changed yet, and to what. */
	bool is_known;
	bool active;
};

static const char *recording;
static struct pin *pins;
static unsigned int pin_count;
static struct change *changes;
static unsigned int change_count;
static bool is_full;
/* The start by the computer's clock and by the image's. */
static int64_t start;
static int64_t start_in_image;

static struct lf_oscilloscope_move *moves;
static unsigned int move_count;

static int64_t nanoseconds(clockid_t clock)
{
	struct timespec time;

	(void)clock_gettime(clock, &time);
	return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

/* As programs of the computer do, it reads the wall clock once and goes on with one that is never set. */
static int64_t now(void)
{
	static int64_t offset;

	if (offset == 0) {
		offset = nanoseconds(CLOCK_REALTIME) - nanoseconds(CLOCK_MONOTONIC);
	}
	return nanoseconds(CLOCK_MONOTONIC) + offset;
}

/* `items` with room for one more than there are; arrays grow by doubling. */
static void *with_room(void *items, unsigned int count, size_t size)
{
	if ((count & (count - 1)) == 0) {
		items = realloc(items, (count == 0 ? 1 : 2 * (size_t)count) * size);
		if (items == NULL) {
			nsi_print_error_and_exit("-lf-vcd: there is no memory left\n");
		}
	}
	return items;
}

static int64_t now_in_image(void)
{
	return (int64_t)nsi_hws_get_time() * 1000;
}

void lf_oscilloscope_set_start(int64_t in_ns)
{
	start_in_image = now_in_image() + in_ns;
	start = now() + in_ns;
}

int64_t lf_oscilloscope_elapsed(void)
{
	return now() - start;
}

/*
 * The image is always behind the computer's clock, by what the computer takes to come to it. Where it is less behind
 * than it was when it told of its start, that start was told too late; so no edge of the program is before the start.
 */
static void improve_start(int64_t time)
{
	int64_t elapsed = now_in_image() - start_in_image;

	/* Later it would be the drift that is seen. */
	if (start != 0 && elapsed < 1000000000 && time - elapsed <= start) {
		start = time - elapsed - 1;
	}
}

void lf_oscilloscope_record_into(const char *file)
{
	recording = file;
}

unsigned int lf_oscilloscope_add_pin(const char *name)
{
	pins = with_room(pins, pin_count, sizeof(*pins));
	pins[pin_count] = (struct pin){.name = strdup(name)};
	return pin_count++;
}

void lf_oscilloscope_note(unsigned int pin, bool active)
{
	if (recording == NULL || (pins[pin].is_known && pins[pin].active == active)) {
		return;
	}
	pins[pin].is_known = true;
	pins[pin].active = active;
	if (change_count == CHANGES_MAX) {
		if (!is_full) {
			nsi_print_warning("-lf-vcd: the recording is full, and ends here\n");
		}
		is_full = true;
		return;
	}
	changes = with_room(changes, change_count, sizeof(*changes));
	changes[change_count] = (struct change){.time = now(), .pin = pin, .active = active};
	improve_start(changes[change_count++].time);
}

/* The digits are the printable characters, as the format asks for. */
static void write_code(FILE *file, unsigned int pin)
{
	do {
		(void)fputc('!' + (int)(pin % 94), file);
		pin /= 94;
	} while (pin != 0);
}

static void write_change(FILE *file, unsigned int pin, bool active)
{
	(void)fputc(active ? '1' : '0', file);
	write_code(file, pin);
	(void)fputc('\n', file);
}

/* Changes before the start count as at the start. */
static void write_changes(FILE *file)
{
	int64_t written = 0;
	unsigned int index = 0;

	for (unsigned int pin = 0; pin < pin_count; pin++) {
		pins[pin].active = false;
	}
	for (; index < change_count && changes[index].time <= start; index++) {
		pins[changes[index].pin].active = changes[index].active;
	}
	(void)fputs("#0\n", file);
	for (unsigned int pin = 0; pin < pin_count; pin++) {
		write_change(file, pin, pins[pin].active);
	}
	for (; index < change_count; index++) {
		int64_t time = changes[index].time - start;

		if (time != written) {
			(void)fprintf(file, "#%" PRId64 "\n", time);
			written = time;
		}
		write_change(file, changes[index].pin, changes[index].active);
	}
}

static void write_recording(void)
{
	const char *slash, *dot;
	FILE *file;

	if (recording == NULL) {
		return;
	}
	file = fopen(recording, "w");
	if (file == NULL) {
		nsi_print_warning("-lf-vcd: cannot write %s: %s\n", recording, strerror(errno));
		return;
	}
	if (start == 0) {
		/* It has not started, so there is nothing to count from but what was recorded. */
		start = change_count == 0 ? now() : changes[0].time;
	}
	slash = strrchr(recording, '/');
	slash = slash == NULL ? recording : slash + 1;
	dot = strrchr(slash, '.');
	(void)fprintf(file, "$comment start %" PRId64 " $end\n$timescale 1 ns $end\n", start);
	(void)fprintf(file, "$scope module %.*s $end\n", dot == NULL ? (int)strlen(slash) : (int)(dot - slash), slash);
	for (unsigned int pin = 0; pin < pin_count; pin++) {
		(void)fputs("$var wire 1 ", file);
		write_code(file, pin);
		(void)fprintf(file, " %s $end\n", pins[pin].name);
	}
	(void)fputs("$upscope $end\n$enddefinitions $end\n", file);
	write_changes(file);
	if (fclose(file) != 0) {
		nsi_print_warning("-lf-vcd: cannot write %s: %s\n", recording, strerror(errno));
	}
}

NSI_TASK(write_recording, ON_EXIT_POST, 10);

void lf_oscilloscope_read_moves(const char *name)
{
	struct lf_oscilloscope_move move;
	char level;
	FILE *file = fopen(name, "r");
	int read;

	if (file == NULL) {
		nsi_print_error_and_exit("-lf-devices: cannot read %s: %s\n", name, strerror(errno));
	}
	while ((read = fscanf(file, "%" SCNd64 " %63s %c %u", &move.at, move.name, &level, &move.line)) == 4) {
		move.active = level == '1';
		moves = with_room(moves, move_count, sizeof(*moves));
		moves[move_count++] = move;
	}
	if (read != EOF) {
		nsi_print_error_and_exit("-lf-devices: %s is not what `lfz moves` has printed\n", name);
	}
	(void)fclose(file);
}

unsigned int lf_oscilloscope_moves(void)
{
	return move_count;
}

const struct lf_oscilloscope_move *lf_oscilloscope_move(unsigned int index)
{
	return &moves[index];
}

void lf_oscilloscope_refuse(const struct lf_oscilloscope_move *move)
{
	nsi_print_error_and_exit("-lf-devices: line %u of the script: this image has no emulated pin %s\n", move->line,
				 move->name);
}
