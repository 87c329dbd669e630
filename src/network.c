/* SPDX-License-Identifier: Apache-2.0 */
/* Waiting for the network: for its interface after boot, and for the ends of its connections before the end. */

#include "network.h"

#include <errno.h>
#include <zephyr/kernel.h>

#ifdef CONFIG_NET_SOCKETS_OFFLOAD

/* The sockets are another system's, which is up before this one. */
int network_wait(void)
{
	return 0;
}

/* The other system goes on with what is still to be sent. */
void network_finish(void)
{
}

#else

#include <zephyr/logging/log.h>
#include <zephyr/net/mld.h>
#include <zephyr/net/net_if.h>

#include <ipv6.h>
#include <tcp_internal.h>

LOG_MODULE_DECLARE(lf, CONFIG_LF_LOG_LEVEL);

/* The interval of looks at the interface: a link takes seconds to come up, and nothing else happens until then. */
#define LOOK_INTERVAL K_MSEC(10)
/* The time for the others to acknowledge the ends of their connections: enough for several retransmissions. */
#define FINISH_LIMIT  K_SECONDS(5)

#ifdef CONFIG_NET_IPV6

#define MY_ADDRESS     "CONFIG_NET_CONFIG_MY_IPV6_ADDR"

static bool has_address(struct net_if *interface)
{
	return net_if_ipv6_get_global_addr(NET_ADDR_PREFERRED, &interface) != NULL;
}

/* The time between two checks of neighbors that Zephyr no longer resolves. */
#define STALL_INTERVAL K_SECONDS(1)

/* Forgets a neighbor that packets wait for and nothing looks for, so that the next packet asks for it anew. Zephyr 4.3
 * and 4.4 leave it so when three packets wait and the answer is lost (zephyr#119443). */
static void forget_if_stalled(struct net_nbr *neighbor, void *unused)
{
	struct net_ipv6_nbr_data *data = net_ipv6_nbr_data(neighbor);
	struct net_pkt *packet;

	ARG_UNUSED(unused);
	if (neighbor->idx != NET_NBR_LLADDR_UNKNOWN || data->send_ns != 0 || !data->pending_queue_initialized ||
	    k_fifo_is_empty(&data->pending_queue)) {
		return;
	}
	while ((packet = k_fifo_get(&data->pending_queue, K_NO_WAIT)) != NULL) {
		/* Nobody else has what waits here, however often it was put here. */
		for (atomic_val_t references = atomic_get(&packet->atomic_ref); references > 0; references--) {
			net_pkt_unref(packet);
		}
	}
	net_ipv6_nbr_rm(neighbor->iface, &data->addr);
}

static void forget_stalled(struct k_work *work)
{
	net_ipv6_nbr_foreach(forget_if_stalled, NULL);
	k_work_reschedule(k_work_delayable_from_work(work), STALL_INTERVAL);
}

static K_WORK_DELAYABLE_DEFINE(forget_stalled_work, forget_stalled);

/* Zephyr's own settings have the address only: without a prefix no other host is known to be on the same link, and
 * without detection of duplicate addresses Zephyr does not join the group in which others ask for the board. */
static void set_up_routes(struct net_if *interface)
{
	struct in6_addr address;
	struct in6_addr solicited;

	if (net_addr_pton(AF_INET6, CONFIG_NET_CONFIG_MY_IPV6_ADDR, &address) == 0) {
		net_if_ipv6_prefix_add(interface, &address, CONFIG_LF_IPV6_PREFIX_LENGTH, UINT32_MAX);
		net_ipv6_addr_create_solicited_node(&address, &solicited);
		/* An interface that is down joins when it comes up. */
		(void)net_ipv6_mld_join(interface, &solicited);
	}
	k_work_reschedule(&forget_stalled_work, STALL_INTERVAL);
	if (sizeof(CONFIG_LF_IPV6_GATEWAY) > 1) {
		if (net_addr_pton(AF_INET6, CONFIG_LF_IPV6_GATEWAY, &address) == 0) {
			net_if_ipv6_router_add(interface, &address, 0);
		} else {
			LOG_ERR("CONFIG_LF_IPV6_GATEWAY is no IPv6 address: %s", CONFIG_LF_IPV6_GATEWAY);
		}
	}
}

#else

#define MY_ADDRESS "CONFIG_NET_CONFIG_MY_IPV4_ADDR"

static bool has_address(struct net_if *interface)
{
	return net_if_ipv4_get_global_addr(interface, NET_ADDR_PREFERRED) != NULL;
}

static void set_up_routes(struct net_if *interface)
{
	ARG_UNUSED(interface);
}

#endif

int network_wait(void)
{
	k_timepoint_t end = sys_timepoint_calc(K_SECONDS(CONFIG_LF_NETWORK_TIMEOUT));
	struct net_if *interface = net_if_get_default();

	if (interface == NULL) {
		LOG_ERR("There is no network interface: enable the board's driver or offloaded sockets");
		return -ENODEV;
	}
	set_up_routes(interface);
	while (!net_if_is_up(interface) || !has_address(interface)) {
		if (sys_timepoint_expired(end)) {
			LOG_ERR("No network after %d s: %s", CONFIG_LF_NETWORK_TIMEOUT,
				net_if_is_up(interface) ? "set " MY_ADDRESS : "the interface is down, check the cable");
			return -ETIMEDOUT;
		}
		k_sleep(LOOK_INTERVAL);
	}
	return 0;
}

static void look_for_unacknowledged(struct tcp *conn, void *found)
{
	enum tcp_state state = net_tcp_get_state(conn);

	/* A connection that is closed with pending data stays established until the peer acknowledges them. */
	*(bool *)found |= conn->in_close || state == TCP_FIN_WAIT_1 || state == TCP_CLOSING || state == TCP_LAST_ACK;
}

void network_finish(void)
{
	k_timepoint_t end = sys_timepoint_calc(FINISH_LIMIT);

	while (true) {
		bool found = false;

		net_tcp_foreach(look_for_unacknowledged, &found);
		if (!found) {
			return;
		}
		if (sys_timepoint_expired(end)) {
			LOG_WRN("Another program has not acknowledged the end of a connection");
			return;
		}
		k_sleep(LOOK_INTERVAL);
	}
}

#endif
