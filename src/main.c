/* SPDX-License-Identifier: Apache-2.0 */
/* The C side of the application: brings the hardware up, then lets the RTI, the federate or both run. */

#include <lf/lf.h>
#include <lf/platform.h>

#ifdef CONFIG_LF_NETWORK
#include "network.h"
#endif

#include <zephyr/logging/log.h>

LOG_MODULE_DECLARE(lf, CONFIG_LF_LOG_LEVEL);

#if defined(CONFIG_LF_RTI) && defined(CONFIG_LF_FEDERATE)

static K_THREAD_STACK_DEFINE(rti_stack, CONFIG_LF_RTI_STACK_SIZE);
static struct k_thread rti_thread;
static int rti_status;

static void run_rti(void *unused_1, void *unused_2, void *unused_3)
{
	ARG_UNUSED(unused_1);
	ARG_UNUSED(unused_2);
	ARG_UNUSED(unused_3);
	rti_status = lf_rti_main();
}

static int run(void)
{
	int status;

	/* From here on federates can connect, so that of this image finds its RTI whichever thread comes first. */
	if (lf_rti_listen() != 0) {
		return 1;
	}
	(void)k_thread_create(&rti_thread, rti_stack, K_THREAD_STACK_SIZEOF(rti_stack), run_rti, NULL, NULL, NULL,
			      K_PRIO_PREEMPT(CONFIG_LF_RTI_PRIORITY), 0, K_NO_WAIT);
	(void)k_thread_name_set(&rti_thread, "lf_rti");
	status = lf_main();
	/* The others may go on for longer, and need their RTI until they have left. */
	(void)k_thread_join(&rti_thread, K_FOREVER);
	return status != 0 ? status : rti_status;
}

#elif defined(CONFIG_LF_RTI)

static int run(void)
{
	return lf_rti_listen() != 0 ? 1 : lf_rti_main();
}

#else

static int run(void)
{
	return lf_main();
}

#endif

int main(void)
{
	int status = 1;

	LOG_INF("lf-zephyr-rs %s", lf_version());
#ifdef CONFIG_LF_NETWORK
	if (network_wait() == 0) {
		status = run();
		network_finish();
	}
#else
	status = run();
#endif
	lf_exit(status);
}
