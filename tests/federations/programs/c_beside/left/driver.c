/* SPDX-License-Identifier: Apache-2.0 */
#include "driver.h"

/* An option of the application's own, which only images have. */
#ifndef CONFIG_MEASURE_FROM
#define CONFIG_MEASURE_FROM 0
#endif

static int value = CONFIG_MEASURE_FROM;

int measure(void)
{
	value += STEP;
	return value;
}
