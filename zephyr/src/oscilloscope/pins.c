/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The image's side: it is wired to all emulated pins. gpio_emul calls at each change of an output, whatever drives it,
 * and at interrupts of inputs. Levels are logical where the devicetree has a name for the pin.
 */

#include "host.h"

#include <lf/oscilloscope.h>
#include <lf/platform.h>

#include <cmdline.h>
#include <soc.h>

#include <zephyr/drivers/gpio/gpio_emul.h>
#include <zephyr/init.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

static char *given_recording;
static char *given_moves;

static void add_options(void)
{
	static struct args_struct_t options[] = {
		{
			.option = "lf-vcd",
			.name = "file",
			.type = 's',
			.dest = (void *)&given_recording,
			.descript = "Write down what emulated pins do, by the computer's clock",
		},
		{
			.option = "lf-devices",
			.name = "file",
			.type = 's',
			.dest = (void *)&given_moves,
			.descript = "Move emulated inputs as this file says, which `lfz moves` prints",
		},
		ARG_TABLE_ENDMARKER,
	};

	native_add_command_line_opts(options);
}

NATIVE_TASK(add_options, PRE_BOOT_1, 10);

struct port {
	const struct device *device;
	struct gpio_callback wiring;
	/* The numbers of its pins in the recording, plus 1; 0 for pins that are not in it. */
	unsigned int numbers[GPIO_MAX_PINS_PER_PORT];
	/* Pins that are active when they are low. */
	gpio_port_pins_t active_low;
};

#define PORT(node) {.device = DEVICE_DT_GET(node)},
static struct port ports[] = {DT_FOREACH_STATUS_OKAY(zephyr_gpio_emul, PORT)};

static struct port *port_of(const struct device *device)
{
	ARRAY_FOR_EACH_PTR(ports, port)
	{
		if (port->device == device) {
			return port;
		}
	}
	return NULL;
}

static const struct lf_named_pin *named(const char *name)
{
	for (size_t index = 0; index < lf_named_pin_count; index++) {
		if (strcmp(lf_named_pins[index].name, name) == 0) {
			return &lf_named_pins[index];
		}
	}
	return NULL;
}

/* A pin is in the recording from when it is first used; its name is the first that there is for it. */
static unsigned int number_of(struct port *port, gpio_pin_t pin)
{
	char number[32];
	const char *name = number;

	if (port->numbers[pin] == 0) {
		snprintk(number, sizeof(number), "%s_%u", port->device->name, pin);
		for (size_t index = lf_named_pin_count; index-- > 0;) {
			const struct gpio_dt_spec *spec = lf_named_pins[index].pin;

			if (spec->port == port->device && spec->pin == pin) {
				name = lf_named_pins[index].name;
				WRITE_BIT(port->active_low, pin, (spec->dt_flags & GPIO_ACTIVE_LOW) != 0);
			}
		}
		port->numbers[pin] = lf_oscilloscope_add_pin(name) + 1;
	}
	return port->numbers[pin] - 1;
}

static void note(struct port *port, gpio_pin_t pin)
{
	gpio_flags_t flags;
	gpio_port_value_t levels = 0;

	if (gpio_emul_flags_get(port->device, pin, &flags) != 0 || (flags & (GPIO_INPUT | GPIO_OUTPUT)) == 0) {
		return;
	}
	if ((flags & GPIO_OUTPUT) != 0) {
		(void)gpio_emul_output_get_masked(port->device, BIT(pin), &levels);
	} else {
		(void)gpio_port_get_raw(port->device, &levels);
	}

	unsigned int number = number_of(port, pin);

	lf_oscilloscope_note(number, ((levels ^ port->active_low) & BIT(pin)) != 0);
}

static void changed(const struct device *device, struct gpio_callback *wiring, gpio_port_pins_t pins)
{
	struct port *port = CONTAINER_OF(wiring, struct port, wiring);

	ARG_UNUSED(device);
	for (; pins != 0; pins &= pins - 1) {
		note(port, (gpio_pin_t)(find_lsb_set(pins) - 1));
	}
}

static unsigned int next_move;

static void move(struct k_timer *timer);

static K_TIMER_DEFINE(hand, move, NULL);

static void move_input(const struct lf_oscilloscope_move *what)
{
	const struct gpio_dt_spec *spec = named(what->name)->pin;
	bool active_low = (spec->dt_flags & GPIO_ACTIVE_LOW) != 0;

	if (gpio_emul_input_set(spec->port, spec->pin, what->active != active_low) == 0) {
		/* Not every move is an interrupt. */
		note(port_of(spec->port), spec->pin);
	}
}

/* Moves what is due by the computer's clock, which the timer's differs from, and then waits for the next move. */
static void move(struct k_timer *timer)
{
	for (; next_move < lf_oscilloscope_moves(); next_move++) {
		const struct lf_oscilloscope_move *next = lf_oscilloscope_move(next_move);
		int64_t left = next->at - lf_oscilloscope_elapsed();

		if (left > 0) {
			k_timer_start(timer, K_NSEC(left), K_NO_WAIT);
			return;
		}
		move_input(next);
	}
}

void lf_oscilloscope_starts(int64_t in_ns)
{
	lf_oscilloscope_set_start(in_ns);
	move(&hand);
}

static int begin(void)
{
	if (given_recording != NULL) {
		lf_oscilloscope_record_into(given_recording);
	}
	if (given_moves != NULL) {
		lf_oscilloscope_read_moves(given_moves);
	}
	for (unsigned int index = 0; index < lf_oscilloscope_moves(); index++) {
		const struct lf_oscilloscope_move *item = lf_oscilloscope_move(index);
		const struct lf_named_pin *pin = named(item->name);

		if (pin == NULL || port_of(pin->pin->port) == NULL) {
			lf_oscilloscope_refuse(item);
		}
	}
	ARRAY_FOR_EACH_PTR(ports, port)
	{
		const struct gpio_driver_config *config = port->device->config;

		gpio_init_callback(&port->wiring, changed, config->port_pin_mask);
		(void)gpio_add_callback(port->device, &port->wiring);
		/* The settings that drivers have made before. */
		changed(port->device, &port->wiring, config->port_pin_mask);
	}
	return 0;
}

/* The last of the kernel's own: the application comes after it, and sees none of its pins move before. */
SYS_INIT(begin, POST_KERNEL, 99);
