/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The C functions that the Rust crate lf-zephyr calls: only those that Rust cannot replace because they need a macro of
 * Zephyr (logging, static stacks), or depend on the C library of the image (errno).
 */
#ifndef LF_PLATFORM_H_
#define LF_PLATFORM_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/kernel.h>
#include <zephyr/net/socket.h>

/* The results of the sockets' calls, independent of the C library's numbers for errno. */
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

/*
 * The wake-up of the event loop of an image without a network. The first may be called from interrupts; the second
 * waits for this number of ticks, or without end if it is negative, and returns whether there was a wake-up.
 */
void lf_wake(void);
bool lf_wait_for_wake(int64_t ticks);

/* The calling thread's errno. */
int lf_errno(void);

/* Classifies an errno value, for instance one that SO_ERROR returned. */
enum lf_network_error lf_network_error(int error);

/*
 * zsock_poll() with a time-out in ticks of the kernel instead of milliseconds; a negative one means without limit.
 * Returns what zsock_poll() returns.
 */
int lf_poll(struct zsock_pollfd *sockets, int count, int64_t timeout_ticks);

/*
 * Fills the buffer with unpredictable numbers, as far as the board has a source of them. Returns 0, or a
 * negative errno.
 */
int lf_random(uint8_t *buffer, size_t size);

/* The public key of a federate. */
struct lf_member {
	uint16_t federate;
	uint8_t key[32];
};

/* The keys of an image. The own secret of a participant that it does not have is all zero. */
struct lf_keys {
	uint8_t own[32];
	uint8_t rti_own[32];
	uint8_t federation[32];
	uint8_t rti[32];
	const struct lf_member *federates;
	size_t federates_count;
};

/* Returns the keys of the image, with CONFIG_LF_SECURITY. */
const struct lf_keys *lf_keys(void);

/* Returns the number of bytes that zsock_send() may take now, so that TCP keeps the buffers to send them. */
size_t lf_send_room(void);

/* Writes a zero-terminated message to Zephyr's log; the levels are Zephyr's LOG_LEVEL_*. */
void lf_log(uint32_t level, const char *message);

/* Writes out what the log still holds and makes it write at once from now on. */
void lf_log_flush(void);

/* Returns the counts of k_cycle_get_32() and k_cycle_get_64() per second; a macro or a variable in Zephyr. */
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

/* Why a call for a device failed, whatever numbers errno has in the C library. */
enum lf_device_problem {
	LF_DEVICE_NO_DRIVER,
	LF_DEVICE_NOT_READY,
	LF_DEVICE_NOT_SUPPORTED,
	LF_DEVICE_FAILED,
};

/* Classifies the negative errno that calls for devices return. */
enum lf_device_problem lf_device_problem(int error);

/* 0 when the driver of a device is in the image and has started. */
struct device;
int lf_device_ready(const struct device *device);

/*
 * Handles an event of a watched device, usually in the interrupt: takes the number of the device's place, which is
 * one of CONFIG_LF_INTERRUPTS and was free, and the value of the event.
 */
typedef void lf_device_handler(size_t place, uint8_t value);

/* Which changes of a pin are interrupts. */
enum lf_edge {
	LF_EDGE_TO_ACTIVE,
	LF_EDGE_TO_INACTIVE,
	LF_EDGE_BOTH,
};

/*
 * Pins, by what the devicetree says of them; whether one is active takes its wiring into account. Each call returns 0,
 * or a negative errno.
 */
struct gpio_dt_spec;
bool lf_pin_is_active_low(const struct gpio_dt_spec *pin);
int lf_pin_output(const struct gpio_dt_spec *pin, bool active);
int lf_pin_input(const struct gpio_dt_spec *pin);
int lf_pin_set(const struct gpio_dt_spec *pin, bool active);
/* Returns 1 when it is active. */
int lf_pin_get(const struct gpio_dt_spec *pin);

/* Calls the handler at each such change, with 1 when the pin is active. */
int lf_pin_watch(size_t place, const struct gpio_dt_spec *pin, enum lf_edge edge, lf_device_handler *handler);
/* Ends that. */
void lf_pin_unwatch(size_t place);

/* The program starts in this many nanoseconds; with CONFIG_LF_OSCILLOSCOPE. */
void lf_oscilloscope_starts(int64_t in_ns);

/* Channels of PWM. */
struct pwm_dt_spec;
int lf_pwm_ready(const struct pwm_dt_spec *channel);
/* In nanoseconds. */
uint32_t lf_pwm_period(const struct pwm_dt_spec *channel);
int lf_pwm_set_pulse(const struct pwm_dt_spec *channel, uint32_t nanoseconds);

/* Channels of analog-to-digital converters. */
struct adc_dt_spec;
int lf_adc_configure(const struct adc_dt_spec *channel);
int lf_adc_sample(const struct adc_dt_spec *channel, int32_t *raw);
int lf_adc_to_millivolts(const struct adc_dt_spec *channel, int32_t *sample);

/* I2C buses, with the address of a device on them or UINT16_MAX. */
struct i2c_dt_spec;
int lf_i2c_ready(const struct i2c_dt_spec *device);
uint16_t lf_i2c_address(const struct i2c_dt_spec *device);

/* One message of a transfer; it is read into the bytes, or they are written. */
struct lf_i2c_message {
	uint8_t *bytes;
	size_t length;
	bool read;
};

/* There is a start between messages of different kinds. At most LF_I2C_MESSAGES, or -EOVERFLOW. */
#define LF_I2C_MESSAGES 8
int lf_i2c_transfer(const struct i2c_dt_spec *device, uint8_t address, const struct lf_i2c_message *messages,
		    size_t count);

/* Devices on SPI buses. */
struct spi_dt_spec;
int lf_spi_ready(const struct spi_dt_spec *device);

/* One part of a transfer: as many bytes are received as sent. Without bytes to send they are 0; either can be NULL. */
struct lf_spi_part {
	const uint8_t *sent;
	uint8_t *received;
	size_t length;
};

/* At most LF_SPI_PARTS, or -EOVERFLOW. */
#define LF_SPI_PARTS 8
int lf_spi_transfer(const struct spi_dt_spec *device, const struct lf_spi_part *parts, size_t count);
/* Ends what transfers with a spec that keeps the device selected have begun. */
int lf_spi_release(const struct spi_dt_spec *device);

/* Serial lines. */
int lf_uart_send(const struct device *line, const uint8_t *bytes, size_t length);
/* Returns the byte, or -EAGAIN when none has come. */
int lf_uart_receive(const struct device *line);
bool lf_uart_is_empty(int error);
/* Calls the handler with each byte that comes. */
int lf_uart_watch(size_t place, const struct device *line, lf_device_handler *handler);
/* Ends that. */
void lf_uart_unwatch(const struct device *line);

/* Sensors; channels are those of enum sensor_channel. */
int lf_sensor_ready(const struct device *sensor);
int lf_sensor_fetch(const struct device *sensor);
/* In millionths of the channel's unit. */
int lf_sensor_value(const struct device *sensor, int channel, int64_t *micro);
/* Calls the handler when a sample is ready. */
int lf_sensor_watch(size_t place, const struct device *sensor, lf_device_handler *handler);
/* Ends that. */
void lf_sensor_unwatch(size_t place, const struct device *sensor);

/*
 * Ends the program. With another status than 0 the system halts or starts again, as CONFIG_LF_FATAL_* says; with 0 it
 * stands still. native_sim exits with the status instead of halting.
 */
FUNC_NORETURN void lf_exit(int status);

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
/* Writes the address, and returns how many bytes it has: 4, 16, or 0 when the setting is none. */
int lf_rti_address(uint8_t octets[16]);
uint32_t lf_rti_port(void);

#endif /* LF_PLATFORM_H_ */
