/* SPDX-License-Identifier: Apache-2.0 */
/* Devices with registers on an emulated I2C bus. */

#define DT_DRV_COMPAT lf_emulated_registers

#include <errno.h>
#include <string.h>

#include <lf/emulation.h>

#include <zephyr/device.h>
#include <zephyr/drivers/emul.h>
#include <zephyr/drivers/i2c_emul.h>
#include <zephyr/kernel.h>

struct registers {
	uint8_t *bytes;
	size_t size;
	size_t register_size;
};

/* Where the next byte is read or written. */
struct cursor {
	size_t at;
};

static struct k_spinlock lock;

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
			/* What is not there reads as a bus that nobody drives. */
			bool is_there = cursor->at < registers->size;

			if (is_read) {
				message->buf[b] = is_there ? registers->bytes[cursor->at] : UINT8_MAX;
			} else if (is_there) {
				registers->bytes[cursor->at] = message->buf[b];
			}
			cursor->at++;
		}
	}
	k_spin_unlock(&lock, key);
	return 0;
}

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
	K_SPINLOCK(&lock) {
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
	K_SPINLOCK(&lock) {
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

static const struct i2c_emul_api api = {
	.transfer = transfer,
};

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
	EMUL_DT_INST_DEFINE(n, begin, &cursor_##n, &registers_##n, &api, NULL);

DT_INST_FOREACH_STATUS_OKAY(DEFINE)
