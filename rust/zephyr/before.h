/* SPDX-License-Identifier: Apache-2.0 */
/* The declarations that have to precede all headers for bindgen, including those of programs. */
#ifndef LF_BEFORE_H_
#define LF_BEFORE_H_

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

#endif
