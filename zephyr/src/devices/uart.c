/* SPDX-License-Identifier: Apache-2.0 */
/* Serial lines. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/drivers/uart.h>

int lf_uart_send(const struct device *line, const uint8_t *bytes, size_t length)
{
	for (size_t i = 0; i < length; i++) {
		uart_poll_out(line, bytes[i]);
	}
	return 0;
}

int lf_uart_receive(const struct device *line)
{
	unsigned char byte;

	switch (uart_poll_in(line, &byte)) {
	case 0:
		return byte;
	case -1:
		return -EAGAIN;
	default:
		return -ENOSYS;
	}
}

bool lf_uart_is_empty(int error)
{
	return error == -EAGAIN;
}

#ifdef CONFIG_UART_INTERRUPT_DRIVEN

/* All lines have the same one. */
static lf_device_handler *volatile receiver;

static void received(const struct device *line, void *place)
{
	uint8_t byte;

	if (uart_irq_update(line) <= 0) {
		return;
	}
	while (uart_irq_rx_ready(line) > 0 && uart_fifo_read(line, &byte, 1) == 1) {
		receiver((size_t)place, byte);
	}
}

int lf_uart_watch(size_t place, const struct device *line, lf_device_handler *handler)
{
	int error;

	receiver = handler;
	error = uart_irq_callback_user_data_set(line, received, (void *)place);
	if (error == 0) {
		uart_irq_rx_enable(line);
	}
	return error;
}

void lf_uart_unwatch(const struct device *line)
{
	uart_irq_rx_disable(line);
}

#else

int lf_uart_watch(size_t place, const struct device *line, lf_device_handler *handler)
{
	ARG_UNUSED(place);
	ARG_UNUSED(line);
	ARG_UNUSED(handler);
	return -ENOTSUP;
}

void lf_uart_unwatch(const struct device *line)
{
	ARG_UNUSED(line);
}

#endif
