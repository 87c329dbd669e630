/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the Rust crate lf-zephyr calls on the C side: only what Rust cannot do itself, because it is a macro of
 * Zephyr (logging, static stacks), or depends on the C library that the image is linked with (errno).
 */
#ifndef LF_PLATFORM_H_
#define LF_PLATFORM_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/kernel.h>
#include <zephyr/net/socket.h>

/* What the calls of the sockets report, whatever numbers the C library gives to errno. */
enum lf_network_error {
	LF_NETWORK_WOULD_BLOCK,
	LF_NETWORK_IN_PROGRESS,
	LF_NETWORK_INTERRUPTED,
	LF_NETWORK_REFUSED,
	LF_NETWORK_RESET,
	LF_NETWORK_UNREACHABLE,
	LF_NETWORK_ADDRESS_IN_USE,
	LF_NETWORK_NO_SOCKET_LEFT,
	LF_NETWORK_NOT_SUPPORTED,
	LF_NETWORK_OTHER,
};

/* The calling thread's errno. */
int lf_errno(void);

/* Classifies an errno value, for instance one that SO_ERROR returned. */
enum lf_network_error lf_network_error(int error);

/*
 * zsock_poll() with a time-out in ticks of the kernel instead of milliseconds; a negative one means for ever.
 * Returns what zsock_poll() returns.
 */
int lf_poll(struct zsock_pollfd *sockets, int count, int64_t timeout_ticks);

/*
 * Fills the buffer with numbers that nobody can predict, as far as the board has a source of them. Returns 0, or a
 * negative errno.
 */
int lf_random(uint8_t *buffer, size_t size);

/* How many bytes may be given to zsock_send() now, so that TCP keeps the buffers that it needs to send them. */
size_t lf_send_room(void);

/* Writes a zero-terminated message to Zephyr's log; the levels are Zephyr's LOG_LEVEL_*. */
void lf_log(uint32_t level, const char *message);

/* Writes out what the log still holds and makes it write at once from now on. */
void lf_log_flush(void);

/* How many times k_cycle_get_32() and k_cycle_get_64() count per second; a macro or a variable in Zephyr. */
uint32_t lf_cycles_per_second(void);

/* irq_lock() and irq_unlock(), which are macros. */
uint32_t lf_interrupts_lock(void);
void lf_interrupts_unlock(uint32_t key);

/* Where println! and eprintln! take turns, so that lines of several threads do not mix. */
extern struct k_mutex lf_console_lock;

/*
 * Starts thread `index` of CONFIG_LF_USER_THREADS on its static stack. The caller makes sure that the thread is
 * not running.
 */
void lf_thread_start(size_t index, void (*entry)(size_t index));

/* Why a call for a pin failed, whatever numbers the C library gives to errno. */
enum lf_pin_problem {
	LF_PIN_NO_DRIVER,
	LF_PIN_NOT_READY,
	LF_PIN_NOT_SUPPORTED,
	LF_PIN_FAILED,
};

enum lf_pin_problem lf_pin_problem(int error);

/* Which changes of a pin are interrupts. */
enum lf_edge {
	LF_EDGE_TO_ACTIVE,
	LF_EDGE_TO_INACTIVE,
	LF_EDGE_BOTH,
};

/*
 * Pins, by what the devicetree says of them; whether one is active takes its wiring into account. Each call returns 0,
 * or a negative errno, which lf_pin_problem() classifies.
 */
struct gpio_dt_spec;
bool lf_pin_is_active_low(const struct gpio_dt_spec *pin);
int lf_pin_output(const struct gpio_dt_spec *pin, bool active);
int lf_pin_input(const struct gpio_dt_spec *pin);
int lf_pin_set(const struct gpio_dt_spec *pin, bool active);
/* Returns 1 when it is active. */
int lf_pin_get(const struct gpio_dt_spec *pin);

/*
 * Calls the handler at each such change, with the number of one of CONFIG_LF_INTERRUPTS places that is free; from the
 * interrupt, as a rule.
 */
int lf_pin_watch(size_t place, const struct gpio_dt_spec *pin, enum lf_edge edge,
		 void (*handler)(size_t place, bool active));
/* Ends that. */
void lf_pin_unwatch(size_t place);

/*
 * Ends the program. With another status than 0 the system halts or starts again, as CONFIG_LF_FATAL_* says; with 0 it
 * stands still. native_sim exits with the status instead of halting.
 */
FUNC_NORETURN void lf_stop(int status);

/* Ends the program because of a fault: prints what it is and what to do. May be called from interrupts. */
FUNC_NORETURN void lf_fault(const char *what, const char *advice);

/*
 * The watchdog of the calling thread's event loop: the first call starts it. Returns after how many nanoseconds at the
 * latest it is to be called again. Without CONFIG_LF_WATCHDOG there is nothing to call it for.
 */
int64_t lf_watchdog_feed(void);

/* Ends the watchdog of the calling thread, whose event loop has ended. */
void lf_watchdog_end(void);

/* Ends all watchdogs. */
void lf_watchdog_stop(void);

/* The settings from Kconfig, which the command line of native_sim overrides. */
const char *lf_federation_id(void);
/* Gives the four bytes of the address; false when the setting is none. */
bool lf_rti_address(uint8_t octets[4]);
uint32_t lf_rti_port(void);

#endif /* LF_PLATFORM_H_ */
