/* SPDX-License-Identifier: Apache-2.0 */
/* Presses the button: in the timer's interrupt, or all at once. */

#include <zephyr/drivers/gpio.h>
#include <zephyr/kernel.h>

static const struct gpio_dt_spec button = GPIO_DT_SPEC_GET(DT_ALIAS(sw0), gpios);
static uint32_t left;

#ifdef CONFIG_GPIO_EMUL

#include <zephyr/drivers/gpio/gpio_emul.h>

static void put(bool high)
{
	(void)gpio_emul_input_set(button.port, button.pin, high);
}

static void prepare(void)
{
}

static bool is_pending(void)
{
	return false;
}

#else

/*
 * Nothing is connected to the pins of the board that QEMU plays. But QEMU's controller remembers what it drove, and
 * takes that for the level of a pin that has become an input.
 */
#define REGISTER(offset) (DT_REG_ADDR(DT_GPIO_CTLR(DT_ALIAS(sw0), gpios)) + (offset))
#define DATA             REGISTER(BIT(DT_GPIO_PIN(DT_ALIAS(sw0), gpios)) << 2)
#define DIRECTION        REGISTER(0x400)
#define INTERRUPT_MASK   REGISTER(0x410)
#define INTERRUPT_STATUS REGISTER(0x414)

static void put(bool high)
{
	sys_set_bit(DIRECTION, button.pin);
	sys_write32(high ? BIT(button.pin) : 0, DATA);
	sys_clear_bit(DIRECTION, button.pin);
}

/* Zephyr's driver clears the bit of this register that lets interrupts through, and it is set where they are. */
static void prepare(void)
{
	sys_set_bit(INTERRUPT_MASK, button.pin);
}

static bool is_pending(void)
{
	return sys_test_bit(INTERRUPT_STATUS, button.pin) != 0;
}

/* There is no resistor that would pull it up. */
static int let_go(void)
{
	put(true);
	return 0;
}

SYS_INIT(let_go, APPLICATION, CONFIG_APPLICATION_INIT_PRIORITY);

#endif

/* Low is pressed; the last edge lets it go. */
static void move(void)
{
	left--;
	put(left % 2 == 0);
}

static void tick(struct k_timer *timer)
{
	/*
	 * QEMU's board stands still when its computer does something else, and then its timer expires several times at
	 * once. No controller can tell two edges from one before its interrupt.
	 */
	if (is_pending()) {
		return;
	}
	move();
	if (left == 0) {
		k_timer_stop(timer);
	}
}

static K_TIMER_DEFINE(timer, tick, NULL);

/* An even number of edges, one per period, or, with a period of 0, now. */
void hand_presses(uint32_t edges, uint32_t period_us)
{
	left = edges;
	if (period_us > 0) {
		prepare();
		k_timer_start(&timer, K_USEC(period_us), K_USEC(period_us));
		return;
	}
	while (left > 0) {
		move();
	}
}
