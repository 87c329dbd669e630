/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of PWM. */

#include <lf/platform.h>

#include <zephyr/drivers/pwm.h>

int lf_pwm_ready(const struct pwm_dt_spec *channel)
{
	return lf_device_ready(channel->dev);
}

uint32_t lf_pwm_period(const struct pwm_dt_spec *channel)
{
	return channel->period;
}

int lf_pwm_set_pulse(const struct pwm_dt_spec *channel, uint32_t nanoseconds)
{
	return pwm_set_pulse_dt(channel, nanoseconds);
}
