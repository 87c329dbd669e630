/* SPDX-License-Identifier: Apache-2.0 */
/* A driver as a vendor has it. */
#ifndef FAN_H_
#define FAN_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/kernel.h>

#define FANS          1
#define FAN_STEP      10
#define FAN_SPEED_MAX CONFIG_FAN_SPEED_MAX

enum fan_state {
	FAN_STANDS,
	FAN_RUNS,
	FAN_TOO_FAST,
};

struct fan {
	uint8_t number;
	/* As small as the compiler makes it. */
	enum fan_state state;
	uint8_t poles;
#ifdef CONFIG_FAN_COUNTS_TURNS
	uint32_t turns;
#endif
	uint16_t speed;
};

struct fan_timer {
	struct k_timer timer;
	enum fan_state then;
};

typedef void (*fan_callback)(const struct fan *fan, bool in_interrupt, void *data);

/* Returns the error, or the new state of the fan. */
enum fan_state fan_set_speed(struct fan *fan, uint16_t speed);
struct fan fan_open(uint8_t number);
size_t fan_size(void);
size_t fan_timer_size(void);

/* Calls back after a time, from the timer's interrupt. */
void fan_call_back(struct fan *fan, k_timeout_t after, fan_callback callback, void *data);

/* Numbers that Rust and C do not pass alike on native_sim. */
float fan_load(const struct fan *fan, float factor);

static inline int fan_steps(const struct fan *fan)
{
	return fan->speed / FAN_STEP;
}

static inline k_timeout_t fan_ms(int ms)
{
	return K_MSEC(ms);
}

#endif
