/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of analog-to-digital converters. */

#include <lf/platform.h>

#include <zephyr/drivers/adc.h>

int lf_adc_configure(const struct adc_dt_spec *channel)
{
	int error = lf_device_ready(channel->dev);

	return error == 0 ? adc_channel_setup_dt(channel) : error;
}

int lf_adc_sample(const struct adc_dt_spec *channel, int32_t *raw)
{
	/* A converter fills 16 or 32 bits, as its resolution needs. */
	union {
		int16_t narrow;
		uint16_t narrow_unsigned;
		int32_t wide;
	} sample = {0};
	struct adc_sequence sequence = {.buffer = &sample, .buffer_size = sizeof(sample)};
	int error = adc_sequence_init_dt(channel, &sequence);

	if (error == 0) {
		error = adc_read_dt(channel, &sequence);
	}
	if (error != 0) {
		return error;
	}
	if (sequence.resolution > 16) {
		*raw = sample.wide;
	} else {
		*raw = channel->channel_cfg.differential ? sample.narrow : sample.narrow_unsigned;
	}
	return 0;
}

int lf_adc_to_millivolts(const struct adc_dt_spec *channel, int32_t *sample)
{
	return adc_raw_to_millivolts_dt(channel, sample);
}
