/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors that measure what they are told. */

#define DT_DRV_COMPAT lf_emulated_sensor

#include <errno.h>

#include <lf/emulation.h>

#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>

struct channel {
	bool is_measured;
	int64_t now;
	/* When it was fetched last, both in millionths of the channel's unit. */
	int64_t sample;
};

struct sensor {
	struct channel channels[SENSOR_CHAN_ALL];
	const struct sensor_trigger *trigger;
	sensor_trigger_handler_t handler;
};

static struct k_spinlock lock;

static int fetch(const struct device *device, enum sensor_channel channel)
{
	struct sensor *sensor = device->data;

	ARG_UNUSED(channel);
	K_SPINLOCK(&lock)
	{
		for (size_t i = 0; i < ARRAY_SIZE(sensor->channels); i++) {
			sensor->channels[i].sample = sensor->channels[i].now;
		}
	}
	return 0;
}

static int get(const struct device *device, enum sensor_channel channel, struct sensor_value *value)
{
	const struct sensor *sensor = device->data;
	int error = -ENOTSUP;

	K_SPINLOCK(&lock)
	{
		if ((size_t)channel < ARRAY_SIZE(sensor->channels) && sensor->channels[channel].is_measured) {
			error = sensor_value_from_micro(value, sensor->channels[channel].sample);
		}
	}
	return error;
}

static int watch(const struct device *device, const struct sensor_trigger *trigger, sensor_trigger_handler_t handler)
{
	struct sensor *sensor = device->data;

	if (trigger->type != SENSOR_TRIG_DATA_READY) {
		return -ENOTSUP;
	}
	K_SPINLOCK(&lock)
	{
		sensor->trigger = trigger;
		sensor->handler = handler;
	}
	return 0;
}

int lf_emulated_sensor_set(const struct device *device, int channel, int64_t micro)
{
	struct sensor *sensor = device->data;
	const struct sensor_trigger *trigger = NULL;
	sensor_trigger_handler_t handler = NULL;

	if (channel < 0 || (size_t)channel >= ARRAY_SIZE(sensor->channels)) {
		return -EINVAL;
	}
	K_SPINLOCK(&lock)
	{
		sensor->channels[channel].is_measured = true;
		sensor->channels[channel].now = micro;
		trigger = sensor->trigger;
		handler = sensor->handler;
	}
	if (handler != NULL) {
		handler(device, trigger);
	}
	return 0;
}

static DEVICE_API(sensor, api) = {
	.sample_fetch = fetch,
	.channel_get = get,
	.trigger_set = watch,
};

#define DEFINE(n)                                                                                                      \
	static struct sensor sensor_##n;                                                                               \
	SENSOR_DEVICE_DT_INST_DEFINE(n, NULL, NULL, &sensor_##n, NULL, POST_KERNEL, CONFIG_SENSOR_INIT_PRIORITY, &api);

DT_INST_FOREACH_STATUS_OKAY(DEFINE)
