/* SPDX-License-Identifier: Apache-2.0 */
#include "fan.h"

#include <zephyr/devicetree.h>

static struct {
	struct fan *fan;
	fan_callback callback;
	void *data;
} waiting;

static void expired(struct k_timer *timer)
{
	waiting.callback(waiting.fan, k_is_in_isr(), waiting.data);
}

static K_TIMER_DEFINE(timer, expired, NULL);

struct fan fan_open(uint8_t number)
{
	return (struct fan){.number = number, .poles = DT_PROP(DT_NODELABEL(fan0), poles)};
}

enum fan_state fan_set_speed(struct fan *fan, uint16_t speed)
{
	if (speed > FAN_SPEED_MAX) {
		return FAN_TOO_FAST;
	}
	fan->speed = speed;
	fan->state = speed > 0 ? FAN_RUNS : FAN_STANDS;
	fan->turns += 1;
	return fan->state;
}

size_t fan_size(void)
{
	return sizeof(struct fan);
}

size_t fan_timer_size(void)
{
	return sizeof(struct fan_timer);
}

void fan_call_back(struct fan *fan, k_timeout_t after, fan_callback callback, void *data)
{
	waiting.fan = fan;
	waiting.callback = callback;
	waiting.data = data;
	k_timer_start(&timer, after, K_NO_WAIT);
}

float fan_load(const struct fan *fan, float factor)
{
	return fan->speed * factor / FAN_SPEED_MAX;
}
