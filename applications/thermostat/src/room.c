/* SPDX-License-Identifier: Apache-2.0 */
/* The room of native_sim: something in it heats, the fan cools it, and the thermometer tells of it. */

#include <lf/emulation.h>

#include <zephyr/device.h>
#include <zephyr/drivers/adc/adc_emul.h>
#include <zephyr/init.h>
#include <zephyr/kernel.h>

#define PERIOD_MS 50
/* The knob is in the middle: 20 degrees. */
#define KNOB_MV   1650

static const struct device *const thermometer = DEVICE_DT_GET(DT_NODELABEL(thermometer));
static const struct device *const fan = DEVICE_DT_GET(DT_NODELABEL(pwm0));
static const struct device *const knob = DEVICE_DT_GET(DT_NODELABEL(adc0));

/* In thousandths of a degree. */
static int32_t temperature = 25000;

static void set_thermometer(void)
{
	/* An LM75 has units of half a degree, in the upper nine bits. */
	uint16_t left = (uint16_t)((temperature / 500) * 128);
	const uint8_t bytes[] = {left >> 8, left & 0xff};

	(void)lf_emulated_registers_set(thermometer, 0, bytes, sizeof(bytes));
}

static void live(struct k_timer *timer)
{
	uint32_t period, pulse;
	int32_t cooling = 0;

	ARG_UNUSED(timer);
	if (lf_emulated_pwm_get(fan, 0, &period, &pulse) == 0 && period > 0) {
		cooling = (int32_t)((uint64_t)pulse * 300 / period);
	}
	temperature += 60 - cooling;
	set_thermometer();
}

static K_TIMER_DEFINE(timer, live, NULL);

static int begin(void)
{
	(void)adc_emul_const_value_set(knob, 0, KNOB_MV);
	set_thermometer();
	k_timer_start(&timer, K_MSEC(PERIOD_MS), K_MSEC(PERIOD_MS));
	return 0;
}

SYS_INIT(begin, APPLICATION, CONFIG_APPLICATION_INIT_PRIORITY);
