/* SPDX-License-Identifier: Apache-2.0 */
/* The values for the devices of the test: a temperature from a model of the fan, a voltage, an acceleration. */

#include <lf/emulation.h>

#include <zephyr/drivers/adc/adc_emul.h>
#include <zephyr/drivers/emul_sensor.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>

/* In units of 0.5 degrees, as the sensor has it. */
void world_temperature(int16_t halves)
{
	uint16_t left = (uint16_t)(halves * 128);
	const uint8_t bytes[] = {left >> 8, left & 0xff};

	(void)lf_emulated_registers_set(DEVICE_DT_GET(DT_NODELABEL(thermometer)), 0, bytes, sizeof(bytes));
}

/* At which temperature the sensor gives an alarm. */
int16_t world_alarm(void)
{
	uint8_t left[2];

	(void)lf_emulated_registers_get(DEVICE_DT_GET(DT_NODELABEL(thermometer)), 3, left, sizeof(left));
	return (int16_t)((left[0] << 8) | left[1]) / 128;
}

void world_voltage(uint32_t millivolts)
{
	(void)adc_emul_const_value_set(DEVICE_DT_GET(DT_NODELABEL(adc0)), 1, millivolts);
}

uint32_t world_fan_pulse(void)
{
	uint32_t period, pulse;

	(void)lf_emulated_pwm_get(DEVICE_DT_GET(DT_NODELABEL(pwm0)), 1, &period, &pulse);
	return pulse;
}

/* 1 g along z. */
void world_gravity(void)
{
	const q31_t g = (q31_t)(9.80665 / 16 * INT32_MAX);

	(void)emul_sensor_backend_set_channel(EMUL_DT_GET(DT_NODELABEL(imu)),
					      (struct sensor_chan_spec){SENSOR_CHAN_ACCEL_Z, 0}, &g, 4);
}

/* Says that it is a BMI160. */
void world_chip(void)
{
	const uint8_t id = 0xd1;

	(void)lf_emulated_registers_set(DEVICE_DT_GET(DT_NODELABEL(chip)), 0, &id, sizeof(id));
}

/* The last command that it was given. */
uint8_t world_chip_command(void)
{
	uint8_t command;

	(void)lf_emulated_registers_get(DEVICE_DT_GET(DT_NODELABEL(chip)), 0x7e, &command, sizeof(command));
	return command;
}

/* In thousandths of a percent, one more each millisecond. */
static void rise(struct k_timer *timer)
{
	static int32_t humidity = 40000;

	ARG_UNUSED(timer);
	humidity++;
	(void)lf_emulated_sensor_set(DEVICE_DT_GET(DT_NODELABEL(climate)), SENSOR_CHAN_HUMIDITY, humidity * 1000LL);
	if (humidity == 40100) {
		k_timer_stop(timer);
	}
}

static K_TIMER_DEFINE(climate, rise, NULL);

void world_climate(void)
{
	k_timer_start(&climate, K_MSEC(1), K_MSEC(1));
}
