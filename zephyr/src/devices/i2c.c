/* SPDX-License-Identifier: Apache-2.0 */
/* I2C buses. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/drivers/i2c.h>

int lf_i2c_ready(const struct i2c_dt_spec *device)
{
	return lf_device_ready(device->bus);
}

uint16_t lf_i2c_address(const struct i2c_dt_spec *device)
{
	return device->addr;
}

int lf_i2c_transfer(const struct i2c_dt_spec *device, uint8_t address, const struct lf_i2c_message *messages,
		    size_t count)
{
	struct i2c_msg converted[LF_I2C_MESSAGES];

	if (count > ARRAY_SIZE(converted)) {
		return -EOVERFLOW;
	}
	for (size_t i = 0; i < count; i++) {
		const struct lf_i2c_message *message = &messages[i];
		uint8_t flags = message->read ? I2C_MSG_READ : I2C_MSG_WRITE;

		/* The bus turns around by another start. */
		if (i > 0 && message->read != messages[i - 1].read) {
			flags |= I2C_MSG_RESTART;
		}
		if (i + 1 == count) {
			flags |= I2C_MSG_STOP;
		}
		converted[i] = (struct i2c_msg){.buf = message->bytes, .len = message->length, .flags = flags};
	}
	return count == 0 ? 0 : i2c_transfer(device->bus, converted, (uint8_t)count, address);
}
