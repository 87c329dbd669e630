/* SPDX-License-Identifier: Apache-2.0 */
/* The headers from which bindgen makes the bindings; build.rs says which items of them. */

/* With KERNEL defined, syscalls are not functions that bindgen sees. */
#undef KERNEL

#ifdef LF_BINDGEN
/* Zephyr's sources get errno from the C library, whose headers bindgen does not read. */
extern int errno;
#endif

#include <zephyr/autoconf.h>

/* gcc defines this for software floating point, clang does not, and the CMSIS headers insist on it. */
#if defined(CONFIG_CPU_CORTEX_M) && !defined(CONFIG_FP_HARDABI) && !defined(__SOFTFP__)
#define __SOFTFP__
#endif

#ifdef CONFIG_SENSOR
#include <zephyr/drivers/sensor.h>
#endif
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/net/socket.h>
#include <zephyr/sys/fdtable.h>
#include <zephyr/sys/printk.h>
#include <zephyr/zvfs/eventfd.h>

#include <lf/platform.h>
