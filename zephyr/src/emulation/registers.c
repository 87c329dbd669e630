/* SPDX-License-Identifier: Apache-2.0 */
/* Devices with registers on an emulated I2C or SPI bus. */

#define DT_DRV_COMPAT lf_emulated_registers

#include <errno.h>
#include <string.h>

#include <lf/emulation.h>

#include <zephyr/device.h>
#include <zephyr/drivers/emul.h>
#include <zephyr/drivers/i2c_emul.h>
#include <zephyr/drivers/spi_emul.h>
#include <zephyr/kernel.h>

struct registers {
	uint8_t *bytes;
	size_t size;
	size_t register_size;
};

/* Where the next byte is read or written. */
struct cursor {
	size_t at;
	/* Of a transfer over SPI that goes on. */
	bool is_selected;
	bool is_read;
};

static struct k_spinlock lock;

#define HAS_I2C DT_ANY_INST_ON_BUS_STATUS_OKAY(i2c)
#define HAS_SPI DT_ANY_INST_ON_BUS_STATUS_OKAY(spi)

static uint8_t read_next(const struct registers *registers, struct cursor *cursor)
{
	size_t at = cursor->at++;

	/* A missing register reads as a bus that no device drives. */
	return at < registers->size ? registers->bytes[at] : UINT8_MAX;
}

static void write_next(const struct registers *registers, struct cursor *cursor, uint8_t byte)
{
	size_t at = cursor->at++;

	if (at < registers->size) {
		registers->bytes[at] = byte;
	}
}

#if HAS_I2C
static int transfer(const struct emul *target, struct i2c_msg *messages, int count, int address)
{
	const struct registers *registers = target->cfg;
	struct cursor *cursor = target->data;
	k_spinlock_key_t key = k_spin_lock(&lock);

	ARG_UNUSED(address);
	for (int i = 0; i < count; i++) {
		const struct i2c_msg *message = &messages[i];
		bool is_read = (message->flags & I2C_MSG_RW_MASK) == I2C_MSG_READ;
		bool begins = i == 0 || (message->flags & I2C_MSG_RESTART) != 0;
		uint32_t from = 0;

		if (!is_read && begins && message->len > 0) {
			cursor->at = message->buf[0] * registers->register_size;
			from = 1;
		}
		for (uint32_t b = from; b < message->len; b++) {
			if (is_read) {
				message->buf[b] = read_next(registers, cursor);
			} else {
				write_next(registers, cursor, message->buf[b]);
			}
		}
	}
	k_spin_unlock(&lock, key);
	return 0;
}
#endif

#if HAS_SPI
/* In the first byte: registers are read. */
#define READ BIT(7)

/* One byte of a buffer, which may have none. */
static uint8_t *byte_of(const struct spi_buf_set *set, size_t part, size_t at)
{
	const struct spi_buf *buffer = set != NULL && part < set->count ? &set->buffers[part] : NULL;

	return buffer != NULL && buffer->buf != NULL && at < buffer->len ? (uint8_t *)buffer->buf + at : NULL;
}

static size_t parts_of(const struct spi_buf_set *set)
{
	return set != NULL ? set->count : 0;
}

static size_t length_of(const struct spi_buf_set *set, size_t part)
{
	return part < parts_of(set) ? set->buffers[part].len : 0;
}

/* Both sets have parts of the same lengths, as lf_spi_transfer() makes them. */
static int exchange(const struct emul *target, const struct spi_config *config, const struct spi_buf_set *sent,
		    const struct spi_buf_set *received)
{
	const struct registers *registers = target->cfg;
	struct cursor *cursor = target->data;
	k_spinlock_key_t key = k_spin_lock(&lock);

	for (size_t part = 0; part < MAX(parts_of(sent), parts_of(received)); part++) {
		for (size_t at = 0; at < MAX(length_of(sent, part), length_of(received, part)); at++) {
			const uint8_t *out = byte_of(sent, part, at);
			uint8_t *in = byte_of(received, part, at);
			uint8_t byte = out != NULL ? *out : 0;
			uint8_t answer = UINT8_MAX;

			if (!cursor->is_selected) {
				cursor->is_selected = true;
				cursor->is_read = (byte & READ) != 0;
				cursor->at = (byte & ~READ) * registers->register_size;
			} else if (cursor->is_read) {
				answer = read_next(registers, cursor);
			} else {
				write_next(registers, cursor, byte);
			}
			if (in != NULL) {
				*in = answer;
			}
		}
	}
	cursor->is_selected = (config->operation & SPI_HOLD_ON_CS) != 0;
	k_spin_unlock(&lock, key);
	return 0;
}
#endif

/* Where these registers begin; NULL when there are fewer. */
static uint8_t *find(const struct registers *registers, uint8_t first, size_t length)
{
	size_t start = first * registers->register_size;

	return start + length <= registers->size ? &registers->bytes[start] : NULL;
}

int lf_emulated_registers_set(const struct device *device, uint8_t first, const uint8_t *bytes, size_t length)
{
	uint8_t *start = find(device->config, first, length);

	if (start == NULL) {
		return -EINVAL;
	}
	K_SPINLOCK(&lock)
	{
		memcpy(start, bytes, length);
	}
	return 0;
}

int lf_emulated_registers_get(const struct device *device, uint8_t first, uint8_t *bytes, size_t length)
{
	const uint8_t *start = find(device->config, first, length);

	if (start == NULL) {
		return -EINVAL;
	}
	K_SPINLOCK(&lock)
	{
		memcpy(bytes, start, length);
	}
	return 0;
}

static int begin(const struct emul *target, const struct device *bus)
{
	ARG_UNUSED(target);
	ARG_UNUSED(bus);
	return 0;
}

#if HAS_I2C
static const struct i2c_emul_api api_i2c = {
	.transfer = transfer,
};
#endif

#if HAS_SPI
static const struct spi_emul_api api_spi = {
	.io = exchange,
};
#endif

#define DEFINE(n)                                                                                                      \
	static uint8_t bytes_##n[DT_INST_PROP(n, registers) * DT_INST_PROP(n, register_size)];                         \
	static struct cursor cursor_##n;                                                                               \
	static const struct registers registers_##n = {                                                                \
		.bytes = bytes_##n,                                                                                    \
		.size = sizeof(bytes_##n),                                                                             \
		.register_size = DT_INST_PROP(n, register_size),                                                       \
	};                                                                                                             \
	DEVICE_DT_INST_DEFINE(n, NULL, NULL, NULL, &registers_##n, POST_KERNEL, CONFIG_KERNEL_INIT_PRIORITY_DEVICE,    \
			      NULL);                                                                                   \
	EMUL_DT_INST_DEFINE(n, begin, &cursor_##n, &registers_##n,                                                     \
			    &COND_CODE_1(DT_INST_ON_BUS(n, spi), (api_spi), (api_i2c)), NULL);

DT_INST_FOREACH_STATUS_OKAY(DEFINE)
