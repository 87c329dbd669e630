/* SPDX-License-Identifier: Apache-2.0 */
/* The functions that the crate lf-c and its C files call of each other; ffi.rs declares them, too. */
#ifndef LF_INTERNAL_H_
#define LF_INTERNAL_H_

/* The functions have the names and the arguments of lf.h, whatever the bodies use. */
#undef LF_MICRO
#include <lf.h>

/* ---- tokens.c ---- */

/* A token with room for this many bytes behind it, or without; it has one owner. Without memory the program ends. */
lf_token_t *lf_c_token_with_room(token_type_t *type, lf_pool_t *pool, size_t length, size_t bytes);
lf_token_t *lf_c_token_for(token_type_t *type, lf_pool_t *pool, void *value, size_t length, uint8_t place);
/* A block of a pool; NULL if it has none, or none so large. */
lf_token_t *lf_c_pool_take(lf_pool_t *pool, size_t bytes);
/* A token with a copy of the elements. */
lf_token_t *lf_c_token_copy(token_type_t *type, lf_pool_t *pool, const void *value, size_t length);
void lf_c_token_retain(lf_token_t *token);
void lf_c_token_release(lf_token_t *token);
/* Copies the value as it lies in memory, if it fits; gives how many bytes it has. */
size_t lf_c_token_encode(const lf_token_t *token, unsigned char *bytes, size_t room);

/* ---- cells.c, for Rust ---- */

bool lf_c_has_trigger(uint16_t trigger);
bool lf_c_shows_trigger(uint16_t trigger);
bool lf_c_port_is_present(uint16_t port);
/* Puts a value into a port, which owns the token from then on. */
void lf_c_port_fill(uint16_t port, lf_token_t *token, tag_t intended);
void lf_c_port_clear(uint16_t port);
/* Copies the value of a port that is present. */
void lf_c_port_copy(uint16_t from, uint16_t to);
/* The value of a port for the delayed connection `trigger` to another port. */
lf_token_t *lf_c_port_capture(uint16_t from, uint16_t to, uint16_t trigger);
/* Writes the bytes of a value if there is room for them; returns their number. */
size_t lf_c_port_encode(uint16_t port, unsigned char *bytes, size_t room);

/* The errors of a value's bytes. */
enum {
	LF_BYTES_GOOD,
	LF_BYTES_LENGTH,    /* they are not as many as `expected` */
	LF_BYTES_REMAINDER, /* they are no whole number of elements of `expected` bytes */
	LF_BYTES_NUL,       /* a text does not end with its only NUL */
};
int lf_c_port_check(uint16_t port, const unsigned char *bytes, size_t size, size_t *expected);
/* The value that is in good bytes, which have come from another federate at `arrival`; NULL if a serializer finds none
 * in them. */
lf_token_t *lf_c_port_decode(uint16_t port, uint16_t trigger, const unsigned char *bytes, size_t size,
			     instant_t arrival);

/* Shows the event of an action, timer or watchdog to bodies. The token still belongs to Rust. */
void lf_c_trigger_show(uint16_t trigger, lf_token_t *token);
void lf_c_trigger_clear(uint16_t trigger);

/* For the names of what has run out of memory. */
bool lf_c_port_has_type(uint16_t port, const token_type_t *type);
bool lf_c_trigger_has_type(uint16_t trigger, const token_type_t *type);

/* Runs a body as the running reaction of this thread, and takes back the copies that it has made. */
void lf_c_run(void (*body)(uint16_t), uint16_t reaction, void *running);

/* ---- linux.c or zephyr.c ---- */

/* Before anything else. */
void lf_c_begin(void);
/* The memory of tokens outside of pools; NULL if there is none. */
lf_token_t *lf_c_store_take(size_t bytes);
void lf_c_store_give(lf_token_t *token);
/* The remedy for an empty store, as the second half of a sentence. */
const char *lf_c_store_advice(void);
/* The memory that bodies allocate, as far as they do: NULL, and nothing, in an image that has none. */
void *lf_c_allocate(size_t bytes);
void lf_c_free(void *value);
/* Changes a count that threads share; returns the new count. */
size_t lf_c_count(size_t *count, int by);
/* Returns the running reaction of this thread; NULL in all threads but that of the event loop, and in interrupts. */
#ifdef __ZEPHYR__
void *lf_c_running(void);
void lf_c_set_running(void *running);
#else
extern __thread void *lf_running_;
inline void *lf_c_running(void)
{
	return lf_running_;
}
inline void lf_c_set_running(void *running)
{
	lf_running_ = running;
}
#endif
/* The system's clock, for the time before the program starts. */
instant_t lf_c_clock(void);
/* Prints a line. */
void lf_c_print_line(const char *prefix, const char *format, va_list arguments) LF_PRINTF_(2, 0);
__attribute__((__noreturn__)) void lf_c_exit(void);

/* ---- Rust ---- */

/* Triggers the reactions of a port for the running reaction of this thread; returns the current tag. */
tag_t lf_c_mark_present(void *running, uint16_t port);
/* Schedules an action with a token, which belongs to it from then on, or without. */
trigger_handle_t lf_c_schedule(uint16_t trigger, interval_t offset, lf_token_t *token);
/* The name of the port or action with this type, for people, without a NUL; returns its length. */
size_t lf_c_name(const token_type_t *type, const char **name);

#endif /* LF_INTERNAL_H_ */
