/* SPDX-License-Identifier: Apache-2.0 */
/* Presses the button of the emulated controller: in the timer's interrupt, or all at once. */

#include <zephyr/drivers/gpio/gpio_emul.h>
#include <zephyr/kernel.h>

static const struct gpio_dt_spec button = GPIO_DT_SPEC_GET(DT_ALIAS(sw0), gpios);
static uint32_t left;

static void move(void)
{
	/* Low is pressed; the last edge lets it go. */
	(void)gpio_emul_input_set(button.port, button.pin, left % 2 == 0);
}

static void tick(struct k_timer *timer)
{
	left--;
	move();
	if (left == 0) {
		k_timer_stop(timer);
	}
}

static K_TIMER_DEFINE(timer, tick, NULL);

void hand_presses(uint32_t edges, uint32_t period_us)
{
	left = edges;
	if (period_us > 0) {
		k_timer_start(&timer, K_USEC(period_us), K_USEC(period_us));
		return;
	}
	while (left > 0) {
		left--;
		move();
	}
}
