/* SPDX-License-Identifier: Apache-2.0 */
#include "driver.h"

static int value;

int measure(void)
{
	value += STEP;
	return value;
}
