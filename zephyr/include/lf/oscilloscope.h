/* SPDX-License-Identifier: Apache-2.0 */
/* native_sim's oscilloscope: what emulated pins do by the computer's clock, and a script that moves inputs. */
#ifndef LF_OSCILLOSCOPE_H_
#define LF_OSCILLOSCOPE_H_

#include <stddef.h>
#include <stdint.h>

#include <zephyr/drivers/gpio.h>

/* The pins that the devicetree has names for, aliases first; a generated file has them. */
struct lf_named_pin {
	const char *name;
	const struct gpio_dt_spec *pin;
};

extern const struct lf_named_pin lf_named_pins[];
extern const size_t lf_named_pin_count;

#endif
