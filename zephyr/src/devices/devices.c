/* SPDX-License-Identifier: Apache-2.0 */
/* The common part of all devices. */

#include <errno.h>

#include <lf/platform.h>

#include <zephyr/device.h>

enum lf_device_problem lf_device_problem(int error)
{
	switch (-error) {
	case ENXIO:
		return LF_DEVICE_NO_DRIVER;
	case ENODEV:
		return LF_DEVICE_NOT_READY;
	case ENOSYS:
	case ENOTSUP:
		return LF_DEVICE_NOT_SUPPORTED;
	default:
		return LF_DEVICE_FAILED;
	}
}

int lf_device_ready(const struct device *device)
{
	if (device == NULL) {
		return -ENXIO;
	}
	return device_is_ready(device) ? 0 : -ENODEV;
}
