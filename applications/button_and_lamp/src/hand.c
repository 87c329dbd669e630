/* SPDX-License-Identifier: Apache-2.0 */
/* Presses the emulated button of native_sim again and again. */

#include <zephyr/drivers/gpio/gpio_emul.h>
#include <zephyr/kernel.h>

static const struct gpio_dt_spec button = GPIO_DT_SPEC_GET(DT_ALIAS(sw0), gpios);

static void move(struct k_timer *timer)
{
	static bool high;

	ARG_UNUSED(timer);
	high = !high;
	(void)gpio_emul_input_set(button.port, button.pin, high);
}

static K_TIMER_DEFINE(timer, move, NULL);

static int begin(void)
{
	k_timer_start(&timer, K_MSEC(75), K_MSEC(75));
	return 0;
}

SYS_INIT(begin, APPLICATION, CONFIG_APPLICATION_INIT_PRIORITY);
