/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The API of micro LF, the C target of boards, for bodies of programs with `target uC`: what differs from lf.h, which
 * includes this file for them. Names that begin with lf_uc_ are for the macros here.
 */
#ifndef LF_UC_H_
#define LF_UC_H_

/* The results of its functions. */
typedef enum {
	LF_OK = 0,
	LF_ERR,
	LF_SLEEP_INTERRUPTED,
	LF_INVALID_TAG,
	LF_AFTER_STOP_TAG,
	LF_PAST_TAG,
	LF_EVENT_QUEUE_EMPTY,
	LF_INVALID_VALUE,
	LF_EVENT_QUEUE_FULL,
	LF_VALUE_BUFFER_FULL,
} lf_ret_t;

/* ---- Checks: the program ends with an error if they fail ---- */

#define validate(condition)                                                                                            \
	do {                                                                                                           \
		if (!(condition)) {                                                                                    \
			lf_print_error_and_exit("%s:%d: not true: %s", __FILE__, __LINE__, #condition);                \
		}                                                                                                      \
	} while (0)
#define validaten(condition) validate(!(condition))
#ifndef __cplusplus
#define throw(message) lf_print_error_and_exit("%s:%d: %s", __FILE__, __LINE__, (message))
#endif

/* ---- Log messages: the first argument, a part of the runtime there, is ignored ---- */

#define LF_DEBUG(part, ...) LF_PRINT_DEBUG(__VA_ARGS__)
#define LF_INFO(part, ...)  lf_print_info(__VA_ARGS__)
#define LF_WARN(part, ...)  lf_print_warning(__VA_ARGS__)
#define LF_ERR(part, ...)   lf_print_error(__VA_ARGS__)

/* ---- Ports and actions ---- */

/* The arguments of a macro by their number. */
#define LF_UC_THIRD_(one, two, third, ...)          third
#define LF_UC_FOURTH_(one, two, three, fourth, ...) fourth

#define lf_get(trigger)        (&(trigger)->value)
#define lf_is_present(trigger) ((trigger)->is_present)

/* Sets a port, with a value if its type has one. */
#undef lf_set
#define lf_set(...) LF_UC_THIRD_(__VA_ARGS__, lf_uc_set_to, lf_set_present, )(__VA_ARGS__)
#define lf_uc_set_to(port, to)                                                                                         \
	do {                                                                                                           \
		__typeof__((port)->value) lf_uc_value_ = (to);                                                         \
		memcpy(&(port)->value, &lf_uc_value_, sizeof(lf_uc_value_));                                           \
		lf_c_set((lf_port_base_t *)(port));                                                                    \
	} while (0)

/* Copies an array to a port, whose type says its length. */
#undef lf_set_array
#define lf_set_array(port, array)                                                                                      \
	do {                                                                                                           \
		memcpy((port)->value, (array), sizeof((port)->value));                                                 \
		lf_c_set((lf_port_base_t *)(port));                                                                    \
	} while (0)

/* Schedules an action, with a value if its type has one. */
#define lf_schedule(...) LF_UC_FOURTH_(__VA_ARGS__, lf_uc_schedule_value, lf_uc_schedule_only, )(__VA_ARGS__)

#define lf_uc_schedule_only(action, offset) lf_uc_returned((lf_schedule)((action), (offset)))
#define lf_uc_schedule_value(action, offset, what)                                                                     \
	({                                                                                                             \
		__typeof__((action)->value) lf_uc_value_ = (what);                                                     \
		lf_uc_returned(lf_schedule_copy((action), (offset), &lf_uc_value_, 1));                                \
	})
#define lf_schedule_array(action, offset, array)   lf_uc_returned(lf_schedule_copy((action), (offset), (array), 1))
#define lf_schedule_with_val(action, offset, what) lf_uc_schedule_value(action, offset, what)
#define lf_schedule_without_val(action, offset)    lf_uc_schedule_only(action, offset)

static inline lf_ret_t lf_uc_returned(trigger_handle_t handle)
{
	return handle < 0 ? LF_ERR : handle == 0 ? LF_AFTER_STOP_TAG : LF_OK;
}

/* ---- The environment: what every body has as `env` ---- */

typedef struct Environment Environment;

typedef struct Scheduler {
	instant_t start_time;
	tag_t (*current_tag)(struct Scheduler *self);
} Scheduler;

typedef struct Platform {
	instant_t (*get_physical_time)(struct Platform *self);
	lf_ret_t (*wait_for)(struct Platform *self, interval_t time);
} Platform;

struct Environment {
	Scheduler *scheduler;
	Platform *platform;
	instant_t (*get_logical_time)(Environment *self);
	interval_t (*get_elapsed_logical_time)(Environment *self);
	instant_t (*get_physical_time)(Environment *self);
	interval_t (*get_elapsed_physical_time)(Environment *self);
	interval_t (*get_lag)(Environment *self);
	lf_ret_t (*wait_for)(Environment *self, interval_t time);
	/* Asks the program to stop, at the next microstep or this much later. */
	void (*request_shutdown)(Environment *self, interval_t offset);
};

static inline tag_t lf_uc_current_tag(Scheduler *self)
{
	(void)self;
	return lf_tag();
}
static inline instant_t lf_uc_platform_time(Platform *self)
{
	(void)self;
	return lf_time_physical();
}
static inline lf_ret_t lf_uc_platform_wait(Platform *self, interval_t time)
{
	(void)self;
	lf_sleep(time);
	return LF_OK;
}
static inline instant_t lf_uc_logical_time(Environment *self)
{
	(void)self;
	return lf_time_logical();
}
static inline interval_t lf_uc_elapsed_logical_time(Environment *self)
{
	(void)self;
	return lf_time_logical_elapsed();
}
static inline instant_t lf_uc_physical_time(Environment *self)
{
	(void)self;
	return lf_time_physical();
}
static inline interval_t lf_uc_elapsed_physical_time(Environment *self)
{
	(void)self;
	return lf_time_physical_elapsed();
}
static inline interval_t lf_uc_lag(Environment *self)
{
	(void)self;
	return lf_time_physical() - lf_time_logical();
}
static inline lf_ret_t lf_uc_wait(Environment *self, interval_t time)
{
	(void)self;
	lf_sleep(time);
	return LF_OK;
}
static inline void lf_uc_request_shutdown(Environment *self, interval_t offset)
{
	(void)self;
	lf_c_request_stop_after(offset);
}

static inline Environment *lf_uc_environment(void)
{
	static Scheduler scheduler = {.current_tag = lf_uc_current_tag};
	static Platform platform = {.get_physical_time = lf_uc_platform_time, .wait_for = lf_uc_platform_wait};
	static Environment environment = {
		.scheduler = &scheduler,
		.platform = &platform,
		.get_logical_time = lf_uc_logical_time,
		.get_elapsed_logical_time = lf_uc_elapsed_logical_time,
		.get_physical_time = lf_uc_physical_time,
		.get_elapsed_physical_time = lf_uc_elapsed_physical_time,
		.get_lag = lf_uc_lag,
		.wait_for = lf_uc_wait,
		.request_shutdown = lf_uc_request_shutdown,
	};
	scheduler.start_time = lf_time_start();
	return &environment;
}

/* The index of a bank's member. */
#define bank_idx bank_index

#endif /* LF_UC_H_ */
