/* SPDX-License-Identifier: Apache-2.0 */
/* Waiting for the network interface after boot. */

#include "network.h"

#include <errno.h>
#include <zephyr/kernel.h>

#ifdef CONFIG_NET_SOCKETS_OFFLOAD

/* The sockets are another system's, which is up before this one. */
int network_wait(void)
{
	return 0;
}

#else

#include <zephyr/logging/log.h>
#include <zephyr/net/net_if.h>

LOG_MODULE_DECLARE(lf, CONFIG_LF_LOG_LEVEL);

/* How often the interface is looked at: a link takes seconds to come up, and nothing else happens until then. */
#define LOOK_INTERVAL K_MSEC(10)

int network_wait(void)
{
	k_timepoint_t end = sys_timepoint_calc(K_SECONDS(CONFIG_LF_NETWORK_TIMEOUT));
	struct net_if *interface = net_if_get_default();

	if (interface == NULL) {
		LOG_ERR("There is no network interface: enable the board's driver or offloaded sockets");
		return -ENODEV;
	}
	while (!net_if_is_up(interface) || net_if_ipv4_get_global_addr(interface, NET_ADDR_PREFERRED) == NULL) {
		if (sys_timepoint_expired(end)) {
			LOG_ERR("No network after %d s: %s", CONFIG_LF_NETWORK_TIMEOUT,
				net_if_is_up(interface) ? "set CONFIG_NET_CONFIG_MY_IPV4_ADDR"
							: "the interface is down, check the cable");
			return -ETIMEDOUT;
		}
		k_sleep(LOOK_INTERVAL);
	}
	return 0;
}

#endif
