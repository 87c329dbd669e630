/* SPDX-License-Identifier: Apache-2.0 */
/* The headers from which bindgen makes the bindings; build.rs says which items of them. */

#include "before.h"

#ifdef CONFIG_SENSOR
#include <zephyr/drivers/sensor.h>
#endif
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#ifdef CONFIG_LF_NETWORK
#include <zephyr/net/socket.h>
#include <zephyr/sys/fdtable.h>
#include <zephyr/zvfs/eventfd.h>
#endif
#include <zephyr/sys/printk.h>

#include <lf/platform.h>
