/* SPDX-License-Identifier: Apache-2.0 */
/* Times and tags. All times are in nanoseconds; those of the federation's clock, as a rule since 1970. */
#ifndef LF_TIME_H_
#define LF_TIME_H_

#include <inttypes.h>
#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int64_t instant_t;
typedef int64_t interval_t;
typedef uint32_t microstep_t;

typedef struct {
	instant_t time;
	microstep_t microstep;
} tag_t;

/* For printf: `lf_print("at " PRINTF_TIME, lf_time_logical())`, `lf_print(PRINTF_TAG, tag.time, tag.microstep)`. */
#define PRINTF_TIME      "%" PRId64
#define PRINTF_MICROSTEP "%" PRIu32
#define PRINTF_TAG       "(%" PRId64 ", %" PRIu32 ")"

#define BILLION ((instant_t)1000000000)

#define NSEC(t)    ((interval_t)((t) * 1LL))
#define NSECS(t)   NSEC(t)
#define USEC(t)    ((interval_t)((t) * 1000LL))
#define USECS(t)   USEC(t)
#define MSEC(t)    ((interval_t)((t) * 1000000LL))
#define MSECS(t)   MSEC(t)
#define SEC(t)     ((interval_t)((t) * 1000000000LL))
#define SECS(t)    SEC(t)
#define SECOND(t)  SEC(t)
#define SECONDS(t) SEC(t)
#define MINUTE(t)  SEC((t) * 60LL)
#define MINUTES(t) MINUTE(t)
#define HOUR(t)    SEC((t) * 3600LL)
#define HOURS(t)   HOUR(t)
#define DAY(t)     SEC((t) * 86400LL)
#define DAYS(t)    DAY(t)
#define WEEK(t)    SEC((t) * 604800LL)
#define WEEKS(t)   WEEK(t)

#define NEVER             ((interval_t)INT64_MIN)
#define FOREVER           ((interval_t)INT64_MAX)
#define NEVER_MICROSTEP   0u
#define FOREVER_MICROSTEP UINT32_MAX

#ifdef __cplusplus
#define LF_TAG_(time, microstep) (tag_t{(time), (microstep)})
#else
#define LF_TAG_(time, microstep) ((tag_t){(time), (microstep)})
#endif
#define NEVER_TAG               LF_TAG_(NEVER, NEVER_MICROSTEP)
#define FOREVER_TAG             LF_TAG_(FOREVER, FOREVER_MICROSTEP)
#define ZERO_TAG                LF_TAG_(0, 0u)
#define NEVER_TAG_INITIALIZER   {NEVER, NEVER_MICROSTEP}
#define FOREVER_TAG_INITIALIZER {FOREVER, FOREVER_MICROSTEP}

/* Whether more than `duration` has passed since `start`. */
#define CHECK_TIMEOUT(start, duration) (lf_time_physical() > ((start) + (duration)))

/*
 * The current tag and time. Outside of reactions, in other threads for example, it is that of the reaction that ran
 * last. The macros ignore their arguments: a program has one environment.
 */
#define lf_tag(...)                  lf_c_tag()
#define lf_time_logical(...)         (lf_c_tag().time)
#define lf_time_logical_elapsed(...) (lf_c_tag().time - lf_time_start())
tag_t lf_c_tag(void);

/* The time at which the program started, on both clocks, or its federation if it has joined that later. */
instant_t lf_time_start(void);
/* The first tag of this program: that of a transient federate may be later. */
tag_t lf_tag_start_effective(void);
instant_t lf_time_physical(void);
instant_t lf_time_physical_elapsed(void);

/* Sums and differences stay at NEVER and FOREVER instead of running over. */
instant_t lf_time_add(instant_t a, interval_t b);
instant_t lf_time_subtract(instant_t a, interval_t b);

/* -1, 0 or 1: the first is earlier, the same, or later. */
int lf_tag_compare(tag_t a, tag_t b);
tag_t lf_tag_min(tag_t a, tag_t b);
tag_t lf_tag_max(tag_t a, tag_t b);

/* The sum; a time of `b` that is greater than 0 begins at microstep 0 of the new time. */
tag_t lf_tag_add(tag_t a, tag_t b);
/* When a value arrives that a connection delays: 0 is one microstep, less than 0 no delay. */
tag_t lf_delay_tag(tag_t tag, interval_t interval);
/* The last tag before that. */
tag_t lf_delay_strict(tag_t tag, interval_t interval);
tag_t lf_tag_latest_earlier(tag_t tag);

/* The size that suffices for the text of any time. */
#define LF_TIME_BUFFER_LENGTH 80
/* Writes "1 weeks, 2 d, 3 h, 4 min, 5 s, 6 ms"; returns the length of the text without its NUL. */
size_t lf_readable_time(char *buffer, instant_t time);
/* Writes "1,234,567"; returns the length of the text without its NUL. */
size_t lf_comma_separated_time(char *buffer, instant_t time);
/* Reads a number and a unit of LF. Returns 0, -1 if the number is none, -2 if the unit is none. */
int lf_time_parse(const char *number, const char *unit, interval_t *result);

#ifdef __cplusplus
}
#endif

#endif /* LF_TIME_H_ */
