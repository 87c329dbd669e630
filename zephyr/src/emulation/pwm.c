/* SPDX-License-Identifier: Apache-2.0 */
/* PWM that drives nothing. */

#define DT_DRV_COMPAT lf_emulated_pwm

#include <errno.h>

#include <lf/emulation.h>

#include <zephyr/drivers/pwm.h>
#include <zephyr/kernel.h>

/* One cycle is a nanosecond. */
#define FREQUENCY 1000000000

struct channel {
	uint32_t period;
	uint32_t pulse;
};

struct channels {
	struct channel *first;
	uint32_t count;
};

static struct k_spinlock lock;

static int set_cycles(const struct device *pwm, uint32_t channel, uint32_t period, uint32_t pulse, pwm_flags_t flags)
{
	const struct channels *channels = pwm->config;

	ARG_UNUSED(flags);
	if (channel >= channels->count) {
		return -EINVAL;
	}
	K_SPINLOCK(&lock)
	{
		channels->first[channel] = (struct channel){.period = period, .pulse = pulse};
	}
	return 0;
}

static int get_cycles_per_sec(const struct device *pwm, uint32_t channel, uint64_t *cycles)
{
	ARG_UNUSED(pwm);
	ARG_UNUSED(channel);
	*cycles = FREQUENCY;
	return 0;
}

int lf_emulated_pwm_get(const struct device *pwm, uint32_t channel, uint32_t *period, uint32_t *pulse)
{
	const struct channels *channels = pwm->config;

	if (channel >= channels->count) {
		return -EINVAL;
	}
	K_SPINLOCK(&lock)
	{
		*period = channels->first[channel].period;
		*pulse = channels->first[channel].pulse;
	}
	return 0;
}

static DEVICE_API(pwm, api) = {
	.set_cycles = set_cycles,
	.get_cycles_per_sec = get_cycles_per_sec,
};

#define DEFINE(n)                                                                                                      \
	static struct channel channels_##n[DT_INST_PROP(n, channels)];                                                 \
	static const struct channels config_##n = {.first = channels_##n, .count = ARRAY_SIZE(channels_##n)};          \
	DEVICE_DT_INST_DEFINE(n, NULL, NULL, NULL, &config_##n, POST_KERNEL, CONFIG_PWM_INIT_PRIORITY, &api);

DT_INST_FOREACH_STATUS_OKAY(DEFINE)
