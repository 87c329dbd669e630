/* SPDX-License-Identifier: Apache-2.0 */
/* The C side of the application: brings the hardware up, then lets the federate run. */

#include <lf/lf.h>
#include <lf/platform.h>

#include "network.h"

#include <zephyr/logging/log.h>

LOG_MODULE_DECLARE(lf, CONFIG_LF_LOG_LEVEL);

int main(void)
{
	int status = 1;

	LOG_INF("lf-zephyr-rs %s", lf_version());
	if (network_wait() == 0) {
		status = lf_main();
	}
	lf_stop(status);
}
