/* SPDX-License-Identifier: Apache-2.0 */
/* Devices on SPI buses. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/drivers/spi.h>

int lf_spi_ready(const struct spi_dt_spec *device)
{
	int error = lf_device_ready(device->bus);

	if (error == 0 && !spi_is_ready_dt(device)) {
		/* The pin that selects it. */
		error = -ENODEV;
	}
	return error;
}

int lf_spi_transfer(const struct spi_dt_spec *device, const struct lf_spi_part *parts, size_t count)
{
	struct spi_buf sent[LF_SPI_PARTS];
	struct spi_buf received[LF_SPI_PARTS];
	const struct spi_buf_set sent_set = {.buffers = sent, .count = count};
	const struct spi_buf_set received_set = {.buffers = received, .count = count};

	if (count > LF_SPI_PARTS) {
		return -EOVERFLOW;
	}
	for (size_t i = 0; i < count; i++) {
		/* Drivers only read from what is sent. */
		sent[i] = (struct spi_buf){.buf = (void *)parts[i].sent, .len = parts[i].length};
		received[i] = (struct spi_buf){.buf = parts[i].received, .len = parts[i].length};
	}
	return spi_transceive_dt(device, &sent_set, &received_set);
}

int lf_spi_release(const struct spi_dt_spec *device)
{
	return spi_release_dt(device);
}
