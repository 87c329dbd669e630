/* SPDX-License-Identifier: Apache-2.0 */
/* Sensors that Zephyr has a driver for. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/drivers/sensor.h>

int lf_sensor_ready(const struct device *sensor)
{
	int error = lf_device_ready(sensor);

	if (error == 0 && !DEVICE_API_IS(sensor, sensor)) {
		error = -ENOTSUP;
	}
	return error;
}

int lf_sensor_fetch(const struct device *sensor)
{
	return sensor_sample_fetch(sensor);
}

int lf_sensor_value(const struct device *sensor, int channel, int64_t *micro)
{
	struct sensor_value value;
	int error = sensor_channel_get(sensor, (enum sensor_channel)channel, &value);

	if (error == 0) {
		*micro = sensor_value_to_micro(&value);
	}
	return error;
}

#if CONFIG_LF_INTERRUPTS > 0

/* All sensors have the same one. */
static lf_device_handler *volatile receiver;

/* Drivers keep pointers to them. */
static struct sensor_trigger triggers[CONFIG_LF_INTERRUPTS];

static void ready(const struct device *sensor, const struct sensor_trigger *trigger)
{
	ARG_UNUSED(sensor);
	receiver((size_t)(trigger - triggers), 0);
}

int lf_sensor_watch(size_t place, const struct device *sensor, lf_device_handler *handler)
{
	receiver = handler;
	triggers[place] = (struct sensor_trigger){.type = SENSOR_TRIG_DATA_READY, .chan = SENSOR_CHAN_ALL};
	return sensor_trigger_set(sensor, &triggers[place], ready);
}

void lf_sensor_unwatch(size_t place, const struct device *sensor)
{
	(void)sensor_trigger_set(sensor, &triggers[place], NULL);
}

#else

int lf_sensor_watch(size_t place, const struct device *sensor, lf_device_handler *handler)
{
	ARG_UNUSED(place);
	ARG_UNUSED(sensor);
	ARG_UNUSED(handler);
	return -ENOTSUP;
}

void lf_sensor_unwatch(size_t place, const struct device *sensor)
{
	ARG_UNUSED(place);
	ARG_UNUSED(sensor);
}

#endif
