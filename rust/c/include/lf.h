/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The interface for bodies in C: the API of Lingua Franca's C target, and the layout of types that generated code and
 * the crate lf-c share. Names that end with an underscore, and those that begin with lf_c_, are for generated code and
 * the macros here.
 */
#ifndef LF_H_
#define LF_H_

#include <assert.h>
#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lf_time.h"
#include "lf_print.h"
#include "lf_threads.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef char *string;
typedef int trigger_handle_t;

#ifndef LF_FILE_SEPARATOR
#define LF_FILE_SEPARATOR "/"
#endif
#ifndef LF_MAX
#define LF_MAX(a, b) (((a) > (b)) ? (a) : (b))
#endif
#ifndef LF_MIN
#define LF_MIN(a, b) (((a) < (b)) ? (a) : (b))
#endif

/* ---- Tokens: what carries values that do not lie in a port itself ---- */

/* The elements of a value. Without a destructor it is freed, without a copy constructor its bytes are copied. */
typedef struct token_type_t {
	size_t element_size;
	void (*destructor)(void *value);
	void *(*copy_constructor)(void *value);
} token_type_t;

/* Blocks of one size for tokens with their values, on boards; on Linux the heap has them. */
typedef struct lf_pool_t {
	unsigned char *blocks;
	size_t block_size;
	uint16_t count;
	/* The maximum number in use so far, and those of them that are free now. */
	uint16_t touched;
	struct lf_token_t *free;
} lf_pool_t;

/* Where the value of a token lies, and so what becomes of it with the token. */
enum {
	LF_VALUE_GIVEN_,    /* somewhere: it is destroyed or freed */
	LF_VALUE_INSIDE_,   /* behind the token */
	LF_VALUE_BORROWED_, /* somewhere: it stays */
};

typedef struct lf_token_t {
	void *value;
	size_t length; /* in elements */
	token_type_t *type;
	size_t ref_count;
	struct lf_token_t *next;
	lf_pool_t *pool;
	/* When it came from another federate. */
	instant_t arrival;
	uint8_t place;
} lf_token_t;

/* A value behind a token can be of any type. */
typedef union {
	long long whole;
	long double real;
	void *pointer;
} lf_any_value_t;
#define LF_TOKEN_SIZE_                                                                                                 \
	((sizeof(lf_token_t) + sizeof(lf_any_value_t) - 1) / sizeof(lf_any_value_t) * sizeof(lf_any_value_t))

/* A pool of `count` values of that size. */
#ifdef __ZEPHYR__
#define LF_POOL(name, value_size, count_)                                                                              \
	static union {                                                                                                 \
		lf_any_value_t align;                                                                                  \
		unsigned char bytes[LF_TOKEN_SIZE_ + (value_size)];                                                    \
	} name##_blocks[count_];                                                                                       \
	lf_pool_t name = {                                                                                             \
		.blocks = name##_blocks[0].bytes,                                                                      \
		.block_size = sizeof(name##_blocks[0]),                                                                \
		.count = (count_),                                                                                     \
	}
#else
#define LF_POOL(name, value_size, count) lf_pool_t name
#endif

/*
 * An image has a heap only if bodies use it: by these names the runtime learns that it may free what they give away.
 * Other sources that allocate what ports get have to include this file, too.
 */
#ifdef __ZEPHYR__
#define malloc(size)          lf_c_malloc(size)
#define calloc(count, size)   lf_c_calloc((count), (size))
#define realloc(memory, size) lf_c_realloc((memory), (size))
void *lf_c_malloc(size_t size);
void *lf_c_calloc(size_t count, size_t size);
void *lf_c_realloc(void *memory, size_t size);
#endif

/* ---- Ports, actions, timers, watchdogs and reactors ---- */

#ifndef __ZEPHYR__
/* The serializer of messages of Protocol Buffers to other federates: functions that protobuf-c generates. */
typedef struct {
	size_t (*size)(const void *message);
	size_t (*pack)(const void *message, unsigned char *bytes);
	void *(*unpack)(const unsigned char *bytes, size_t size); /* NULL if they are no such message */
} lf_serializer_t;

/* Defines `name`, the serializer of a type whose functions begin with `function`, and how its messages are copied and
 * freed. */
#define LF_SERIALIZER_(name, type, function)                                                                           \
	static size_t name##_size(const void *message)                                                                 \
	{                                                                                                              \
		return function##__get_packed_size((const type *)message);                                             \
	}                                                                                                              \
	static size_t name##_pack(const void *message, unsigned char *bytes)                                           \
	{                                                                                                              \
		return function##__pack((const type *)message, bytes);                                                 \
	}                                                                                                              \
	static void *name##_unpack(const unsigned char *bytes, size_t size)                                            \
	{                                                                                                              \
		return function##__unpack(NULL, size, bytes);                                                          \
	}                                                                                                              \
	static inline void name##_free(void *message)                                                                  \
	{                                                                                                              \
		function##__free_unpacked((type *)message, NULL);                                                      \
	}                                                                                                              \
	static inline void *name##_copy(void *message)                                                                 \
	{                                                                                                              \
		size_t size = name##_size(message);                                                                    \
		unsigned char *bytes = (unsigned char *)malloc(size + 1);                                              \
		void *copy = bytes != NULL ? name##_unpack(bytes, name##_pack(message, bytes)) : NULL;                 \
		free(bytes);                                                                                           \
		return copy;                                                                                           \
	}                                                                                                              \
	static const lf_serializer_t name = {name##_size, name##_pack, name##_unpack}
#endif

/* The values of a port or an action from generated code; all others are 0. */
typedef struct {
	uint16_t id;      /* of a port among lf_ports, else among lf_triggers */
	bool is_token;    /* the type ends with * or []: the value is a pointer to elements that a token has */
	bool is_string;   /* the type is `string`: on the network the text and its NUL, not the pointer */
	uint16_t readers; /* reactions, sends and delays that see it */
	size_t value_offset;
	size_t value_size;
	lf_pool_t *pool; /* for values that are set or scheduled; NULL: the general store */
#ifndef __ZEPHYR__
	const lf_serializer_t *serializer; /* NULL: values are sent as they lie in memory */
#endif
} lf_cell_info_t;

#define LF_MAY_ALIAS_ __attribute__((__may_alias__))

#define LF_PORT_FIELDS_                                                                                                \
	token_type_t type;                                                                                             \
	lf_token_t *token;                                                                                             \
	size_t length;                                                                                                 \
	bool is_present;                                                                                               \
	tag_t intended_tag;                                                                                            \
	instant_t physical_time_of_arrival;                                                                            \
	const lf_cell_info_t *info
#ifdef LF_MICRO
/* Bodies find these also where micro LF has them. */
#define LF_PORT_BASE                                                                                                   \
	union {                                                                                                        \
		struct {                                                                                               \
			LF_PORT_FIELDS_;                                                                               \
		};                                                                                                     \
		struct {                                                                                               \
			LF_PORT_FIELDS_;                                                                               \
		} super;                                                                                               \
	}
#else
#define LF_PORT_BASE LF_PORT_FIELDS_
#endif
/* The common part of all ports. Each of them is of a type of its own, whose values this type may alias. */
typedef struct LF_MAY_ALIAS_ lf_port_base_t {
	LF_PORT_BASE;
} lf_port_base_t;

#define LF_ACTION_BASE                                                                                                 \
	token_type_t type;                                                                                             \
	lf_token_t *token;                                                                                             \
	size_t length;                                                                                                 \
	bool is_present;                                                                                               \
	bool has_value;                                                                                                \
	const lf_cell_info_t *info
/* The same for actions. */
typedef struct LF_MAY_ALIAS_ lf_action_base_t {
	LF_ACTION_BASE;
} lf_action_base_t;
typedef lf_action_base_t lf_timer_t;
typedef lf_action_base_t lf_watchdog_t;
typedef lf_watchdog_t watchdog_t;

/* The beginning of each reactor's `self`. */
typedef struct environment_t environment_t;
typedef struct lf_self_base_t {
	const char *name;
	const char *full_name;
	environment_t *environment;
	int bank_index;
} lf_self_base_t;
typedef lf_self_base_t self_base_t;

#define lf_reactor_name(self)      ((self)->base.name)
#define lf_reactor_full_name(self) ((self)->base.full_name)

/* ---- Outputs ---- */

/* Sets a port. The port owns the target of a pointer from then on, as for lf_set_array() of one element. */
#define lf_set(port, to)                                                                                               \
	do {                                                                                                           \
		(port)->value = to;                                                                                    \
		lf_c_set((lf_port_base_t *)(port));                                                                    \
	} while (0)

/* Says that a port is present whose value the body has written to it. */
#define lf_set_present(port) lf_c_set_present((lf_port_base_t *)(port))

/* Sets a port to elements that are freed, or passed to the type's destructor, with the last share. */
#define lf_set_array(port, elements, count)                                                                            \
	do {                                                                                                           \
		(port)->value =                                                                                        \
			LF_AS_TYPE_OF_((port)->value) lf_c_set_array((lf_port_base_t *)(port), (elements), (count));   \
	} while (0)

/* Sets a port to the value of a token: that of an input or an action, or one of lf_new_token(). */
#define lf_set_token(port, new_token)                                                                                  \
	do {                                                                                                           \
		(port)->value = LF_AS_TYPE_OF_((port)->value) lf_c_set_token((lf_port_base_t *)(port), (new_token));   \
	} while (0)

#define lf_set_destructor(port, function)       (((token_type_t *)(port))->destructor = (function))
#define lf_set_copy_constructor(port, function) (((token_type_t *)(port))->copy_constructor = (function))

/* A token for elements of the type of a port or an action; it has them from then on. */
lf_token_t *lf_new_token(void *port_or_action, void *elements, size_t count);

/* The token of an input, or a copy of it if another reaction sees it too. A copy lives as long as the reaction runs. */
#define lf_writable_copy(port) lf_c_writable_copy((lf_port_base_t *)(port))

/* Makes a private copy of the value of a `mutable` input. `port` is the body's own copy of the port's struct. */
void lf_c_make_mutable(lf_port_base_t *port);

#ifdef __cplusplus
#define LF_AS_TYPE_OF_(value) (decltype(value))
#else
#define LF_AS_TYPE_OF_(value)
#endif
void lf_c_set(lf_port_base_t *port);
void lf_c_set_present(lf_port_base_t *port);
void *lf_c_set_array(lf_port_base_t *port, void *elements, size_t count);
void *lf_c_set_token(lf_port_base_t *port, lf_token_t *token);
lf_token_t *lf_c_writable_copy(lf_port_base_t *port);

/* ---- Multiports of which few channels are present ---- */

/* The address of a channel, which bodies have as a pointer to a type of its own. */
typedef lf_port_base_t *LF_MAY_ALIAS_ lf_channel_t;

/* Goes over the channels that are present: `int i; while ((i = lf_multiport_next(&iterator)) >= 0) …`. */
typedef struct lf_multiport_iterator_t {
	lf_channel_t *ports;
	int width;
	int next;
} lf_multiport_iterator_t;

#define lf_multiport_iterator(port) ((lf_multiport_iterator_t)LF_ITERATOR_((lf_channel_t *)(port), port##_width))
#define LF_ITERATOR_(ports, width)  {(ports), (width), 0}
/* The next channel that is present, or -1. */
int lf_multiport_next(lf_multiport_iterator_t *iterator);

/* ---- Actions ---- */

/*
 * Schedules an action, later by `offset` on top of its minimum delay. A physical action can be scheduled in any thread
 * and in interrupts, a logical one in reactions only. Returns a positive number, 0 if there is no event, or -1 for an
 * error, of which a line says what it is.
 */
trigger_handle_t lf_schedule(void *action, interval_t offset);
trigger_handle_t lf_schedule_int(void *action, interval_t offset, int value);
trigger_handle_t lf_schedule_token(void *action, interval_t offset, lf_token_t *token);
/* The elements belong to the event from then on, also in case of an error. */
trigger_handle_t lf_schedule_value(void *action, interval_t offset, void *elements, int count);
/* The elements are copied. */
trigger_handle_t lf_schedule_copy(void *action, interval_t offset, const void *elements, size_t count);

/* ---- Watchdogs, modes, deadlines, the end ---- */

#define lf_watchdog_start(watchdog, additional) lf_c_watchdog_start((watchdog)->info->id, (additional))
#define lf_watchdog_stop(watchdog)              lf_c_watchdog_stop((watchdog)->info->id)
void lf_c_watchdog_start(uint16_t trigger, interval_t additional);
void lf_c_watchdog_stop(uint16_t trigger);

/* A mode among the effects of a reaction: `lf_set_mode(Two)`. */
typedef struct {
	uint16_t mode;
	bool history;
} lf_mode_change_t;
void lf_set_mode(lf_mode_change_t change);

/* Whether the deadline of the reaction that runs has passed; with `handle` its handler runs then. */
#define lf_check_deadline(self, handle) lf_c_check_deadline(handle)
bool lf_c_check_deadline(bool handle);
/* The deadline of the reaction that runs, from its next time on. */
#define lf_update_deadline(self, deadline) lf_c_update_deadline(deadline)
void lf_c_update_deadline(interval_t deadline);

/* A program is not traced, so these do nothing, as in the C runtime where it is not. */
static inline int register_user_trace_event(void *self, char *description)
{
	return self != NULL && description != NULL;
}
static inline void tracepoint_user_event(void *self, char *description)
{
	(void)self;
	(void)description;
}
static inline void tracepoint_user_value(void *self, char *description, long long value)
{
	(void)self;
	(void)description;
	(void)value;
}

/* The wait of a federate's tags for messages that can be tardy. */
interval_t lf_get_fed_maxwait(void);
void lf_set_fed_maxwait(interval_t max_wait);
#define lf_get_stp_offset()       lf_get_fed_maxwait()
#define lf_set_stp_offset(offset) lf_set_fed_maxwait(offset)
#define lf_get_sta()              lf_get_fed_maxwait()
#define lf_set_sta(offset)        lf_set_fed_maxwait(offset)

/* The number of the federate; 65535 in a program that is not federated. */
#ifdef LF_FEDERATE_ID_
#define lf_fed_id() ((uint16_t)LF_FEDERATE_ID_)
#else
#define lf_fed_id() UINT16_MAX
#endif

/* The id of the federation; empty in a program that is not federated. */
const char *lf_get_federation_id(void);

/* Stops this program alone, at the next microstep; the other federates go on without it. */
void lf_stop(void);
/* Asks the program to stop: at the next microstep, or later where other federates have to agree. */
void lf_request_stop(void);
/* The same, this much later in logical time. */
void lf_c_request_stop_after(interval_t offset);

/* ---- Parts of generated code ---- */

extern lf_port_base_t *const lf_ports[];
extern const uint16_t lf_port_count;
/* NULL for startup, shutdown, delays and network inputs. */
extern lf_action_base_t *const lf_triggers[];
/* Where the values of delays and network inputs are while they wait; NULL: the general store. */
extern lf_pool_t *const lf_queue_pools[];
/* The length of both. */
extern const uint16_t lf_trigger_count;
void lf_construct(void);
/* A value for a parameter of the main reactor; whether its type has it. Called before lf_construct() if at all. */
bool lf_give_parameter(uint16_t parameter, long long whole, double real, char *text);
void lf_react(uint16_t reaction);
void lf_miss_deadline(uint16_t reaction);
void lf_handle_tardy(uint16_t reaction);
void lf_reset_mode(uint16_t mode);
/* The place and the size of a state for the instance that takes the place of this one. */
void *lf_handed_over(uint16_t state, size_t *size);

#ifdef __cplusplus
}

/* Sets state and parameters, which may be arrays, to the value at an address. */
template <typename T> inline void lf_assign_(T &to, const void *from)
{
	to = *static_cast<const T *>(from);
}
template <typename T, size_t length> inline void lf_assign_(T (&to)[length], const void *from)
{
	for (size_t i = 0; i < length; i++) {
		lf_assign_(to[i], static_cast<const T *>(from) + i);
	}
}
#define LF_ASSIGN_(to, from)           lf_assign_((to), (from))
#define LF_CLEAR_(to)                  ((to) = __typeof__(to)())
#define LF_ASSERT_(condition, message) static_assert(condition, message)
#else
#define LF_ASSIGN_(to, from)           ((void)memcpy(&(to), (from), sizeof(to)))
#define LF_CLEAR_(to)                  ((void)memset(&(to), 0, sizeof(to)))
#define LF_ASSERT_(condition, message) _Static_assert(condition, message)
#endif

#define LF_TEXT_(...) #__VA_ARGS__
/* A macro without arguments would replace this name, which the program has declared. */
#define LF_NAME_(text, name)                                                                                           \
	LF_ASSERT_(__builtin_strcmp(LF_TEXT_(name), text) == 0,                                                        \
		   "`" text "` is a macro of a header here: choose another name")

#ifdef LF_MICRO
#include "lf_uc.h"
#endif

#endif /* LF_H_ */
