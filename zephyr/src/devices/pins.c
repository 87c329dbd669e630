/* SPDX-License-Identifier: Apache-2.0 */
/* Pins and their interrupts. Zephyr's calls for them are inline functions of its drivers' tables, so C makes them. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/drivers/gpio.h>

bool lf_pin_is_active_low(const struct gpio_dt_spec *pin)
{
	return (pin->dt_flags & GPIO_ACTIVE_LOW) != 0;
}

static int configure(const struct gpio_dt_spec *pin, gpio_flags_t flags)
{
	int error = lf_device_ready(pin->port);

	return error == 0 ? gpio_pin_configure_dt(pin, flags) : error;
}

int lf_pin_output(const struct gpio_dt_spec *pin, bool active)
{
	return configure(pin, active ? GPIO_OUTPUT_ACTIVE : GPIO_OUTPUT_INACTIVE);
}

int lf_pin_input(const struct gpio_dt_spec *pin)
{
	return configure(pin, GPIO_INPUT);
}

int lf_pin_set(const struct gpio_dt_spec *pin, bool active)
{
	return gpio_pin_set_dt(pin, active);
}

int lf_pin_get(const struct gpio_dt_spec *pin)
{
	return gpio_pin_get_dt(pin);
}

#if CONFIG_LF_INTERRUPTS > 0

struct place {
	struct gpio_callback callback;
	const struct gpio_dt_spec *pin;
	enum lf_edge edge;
	lf_device_handler *handler;
};

static struct place places[CONFIG_LF_INTERRUPTS];

static void happened(const struct device *port, struct gpio_callback *callback, gpio_port_pins_t pins)
{
	struct place *place = CONTAINER_OF(callback, struct place, callback);
	/* After one kind of edge the level is known, however short the pulse was. */
	bool active = place->edge == LF_EDGE_BOTH ? gpio_pin_get_dt(place->pin) > 0 : place->edge == LF_EDGE_TO_ACTIVE;

	ARG_UNUSED(port);
	ARG_UNUSED(pins);
	place->handler((size_t)(place - places), active);
}

int lf_pin_watch(size_t index, const struct gpio_dt_spec *pin, enum lf_edge edge, lf_device_handler *handler)
{
	static const gpio_flags_t flags[] = {
		[LF_EDGE_TO_ACTIVE] = GPIO_INT_EDGE_TO_ACTIVE,
		[LF_EDGE_TO_INACTIVE] = GPIO_INT_EDGE_TO_INACTIVE,
		[LF_EDGE_BOTH] = GPIO_INT_EDGE_BOTH,
	};
	struct place *place = &places[index];
	int error;

	place->pin = pin;
	place->edge = edge;
	place->handler = handler;
	gpio_init_callback(&place->callback, happened, BIT(pin->pin));
	error = gpio_add_callback_dt(pin, &place->callback);
	if (error == 0) {
		error = gpio_pin_interrupt_configure_dt(pin, flags[edge]);
		if (error != 0) {
			(void)gpio_remove_callback_dt(pin, &place->callback);
		}
	}
	return error;
}

void lf_pin_unwatch(size_t index)
{
	struct place *place = &places[index];

	(void)gpio_pin_interrupt_configure_dt(place->pin, GPIO_INT_DISABLE);
	(void)gpio_remove_callback_dt(place->pin, &place->callback);
}

#else

int lf_pin_watch(size_t index, const struct gpio_dt_spec *pin, enum lf_edge edge, lf_device_handler *handler)
{
	ARG_UNUSED(index);
	ARG_UNUSED(pin);
	ARG_UNUSED(edge);
	ARG_UNUSED(handler);
	return -ENOTSUP;
}

void lf_pin_unwatch(size_t index)
{
	ARG_UNUSED(index);
}

#endif
