/* SPDX-License-Identifier: Apache-2.0 */
#include <lf.h>

/* As a preamble has it. */
#include <zephyr/kernel.h>

typedef struct {
	uint8_t id;
	double volts;
} point_t;
