/* SPDX-License-Identifier: Apache-2.0 */
/* Errors, waiting and logging, for the Rust crate lf-zephyr. */

#include <lf/platform.h>

#include <errno.h>

#include <zephyr/irq.h>
#include <zephyr/logging/log.h>

#ifdef CONFIG_ARCH_POSIX
#include <nsi_host_trampolines.h>
#endif

#if defined(CONFIG_LF_AUTHENTICATION) || defined(CONFIG_LF_SECURITY)
#include <zephyr/random/random.h>
#endif

#ifdef CONFIG_LF_AUTHENTICATION

BUILD_ASSERT(IS_ENABLED(CONFIG_ARCH_POSIX) || IS_ENABLED(CONFIG_CSPRNG_ENABLED) ||
		     IS_ENABLED(CONFIG_TEST_CSPRNG_GENERATOR),
	     "authentication needs random numbers: this board has no driver for its entropy source");
#endif

#ifdef CONFIG_LF_SECURITY
BUILD_ASSERT(IS_ENABLED(CONFIG_ARCH_POSIX) || IS_ENABLED(CONFIG_LF_SECURITY_TEST_ENTROPY) ||
		     (IS_ENABLED(CONFIG_CSPRNG_ENABLED) && !IS_ENABLED(CONFIG_TEST_CSPRNG_GENERATOR)),
	     "encryption needs random numbers: this board has no driver for its entropy source. For tests only, "
	     "CONFIG_LF_SECURITY_TEST_ENTROPY takes numbers that everybody can know");
#endif

LOG_MODULE_REGISTER(lf, CONFIG_LF_LOG_LEVEL);

/* As a dependency in Kconfig it would depend on itself, by way of what restarts the system. */
BUILD_ASSERT(IS_ENABLED(CONFIG_PRINTK), "CONFIG_PRINTK must be set: println! and what is said of faults need it");

#ifdef CONFIG_LF_NETWORK
/* A socket may be waited for in both directions, each of which takes one entry; the wake-up takes one more. */
BUILD_ASSERT(CONFIG_ZVFS_POLL_MAX >= 2 * CONFIG_LF_SOCKETS + 1,
	     "CONFIG_ZVFS_POLL_MAX must be at least 2 * CONFIG_LF_SOCKETS + 1");
BUILD_ASSERT(CONFIG_ZVFS_OPEN_MAX >= CONFIG_LF_SOCKETS + 1,
	     "CONFIG_ZVFS_OPEN_MAX must be at least CONFIG_LF_SOCKETS + 1");
#endif

#ifdef CONFIG_LF_RTI
/* Beside the connections it has a listener, and perhaps a port for datagrams. */
BUILD_ASSERT(CONFIG_ZVFS_POLL_MAX >= 2 * (CONFIG_LF_RTI_CONNECTIONS + 1) + IS_ENABLED(CONFIG_NET_UDP),
	     "CONFIG_ZVFS_POLL_MAX must be at least 2 * CONFIG_LF_RTI_CONNECTIONS + 3");
BUILD_ASSERT(CONFIG_ZVFS_OPEN_MAX >= CONFIG_LF_RTI_CONNECTIONS + 1 + IS_ENABLED(CONFIG_NET_UDP),
	     "CONFIG_ZVFS_OPEN_MAX must be at least CONFIG_LF_RTI_CONNECTIONS + 2");
BUILD_ASSERT(CONFIG_LF_RTI_CONNECTIONS >= CONFIG_LF_RTI_FEDERATES,
	     "CONFIG_LF_RTI_CONNECTIONS must be at least CONFIG_LF_RTI_FEDERATES");
#endif

K_MUTEX_DEFINE(lf_console_lock);

#ifndef CONFIG_LF_NETWORK

/* The wake-up of the event loop; with sockets it is a descriptor, which is polled with theirs. */
static K_SEM_DEFINE(wake, 0, 1);

void lf_wake(void)
{
	k_sem_give(&wake);
}

bool lf_wait_for_wake(int64_t ticks)
{
	return k_sem_take(&wake, ticks < 0 ? K_FOREVER : K_TICKS(ticks)) == 0;
}

#endif

int lf_errno(void)
{
	return errno;
}

enum lf_network_error lf_network_error(int error)
{
	switch (error) {
	case EAGAIN:
#if EWOULDBLOCK != EAGAIN
	case EWOULDBLOCK:
#endif
		return LF_NETWORK_WOULD_BLOCK;
	case EINPROGRESS:
	case EALREADY:
		return LF_NETWORK_IN_PROGRESS;
	case EINTR:
	case ECONNABORTED:
		return LF_NETWORK_INTERRUPTED;
	case ECONNREFUSED:
		return LF_NETWORK_REFUSED;
	case ECONNRESET:
	case EPIPE:
	case ETIMEDOUT:
	case ENOTCONN:
		return LF_NETWORK_RESET;
	case ENETUNREACH:
	case EHOSTUNREACH:
	case ENETDOWN:
	/* So Zephyr ends connections whose interface goes down. */
	case ENETRESET:
		return LF_NETWORK_UNREACHABLE;
	case EADDRINUSE:
		return LF_NETWORK_ADDRESS_IN_USE;
	case ENFILE:
	case EMFILE:
	/* Zephyr also has no memory when it has no place for a connection. A socket that is open has no buffers then.
	 */
	case ENOMEM:
	case ENOBUFS:
	/* So Zephyr says that all CONFIG_NET_MAX_CONN are in use. */
	case ENOENT:
		return LF_NETWORK_NO_SOCKET_LEFT;
	case EOPNOTSUPP:
#if ENOTSUP != EOPNOTSUPP
	case ENOTSUP:
#endif
		return LF_NETWORK_NOT_SUPPORTED;
	default:
		return LF_NETWORK_OTHER;
	}
}

#if defined(CONFIG_NET_NATIVE_TCP) && defined(CONFIG_NET_BUF_FIXED_DATA_SIZE) && !defined(CONFIG_NET_SOCKETS_OFFLOAD)

#include <zephyr/net/net_ip.h>
#include <zephyr/net/net_pkt.h>

/* TCP keeps what it was given until the peer has it, and sends copies, for which it needs headers too. */
#define BUFFERS_FOR_COPIES     (CONFIG_NET_BUF_TX_COUNT / 2 + 2)
/* A connection is given so much at once, at least. */
#define BUFFERS_PER_CONNECTION DIV_ROUND_UP(NET_IPV6_MTU, CONFIG_NET_BUF_DATA_SIZE)
#ifdef CONFIG_LF_RTI
#define CONNECTIONS (CONFIG_LF_SOCKETS + CONFIG_LF_RTI_CONNECTIONS)
#else
#define CONNECTIONS CONFIG_LF_SOCKETS
#endif

/*
 * Connections that all have much to send could take all buffers, and then TCP could send none of it, ever. Where the
 * buffers are enough for all connections, each connection's own limit is what counts.
 */
size_t lf_send_room(void)
{
	struct k_mem_slab *receive, *send;
	struct net_buf_pool *receive_data, *send_data;
	int available;

	if (CONNECTIONS * BUFFERS_PER_CONNECTION + BUFFERS_FOR_COPIES <= CONFIG_NET_BUF_TX_COUNT) {
		return SIZE_MAX;
	}
	net_pkt_get_info(&receive, &send, &receive_data, &send_data);
	available = (int)atomic_get(&send_data->avail_count) - BUFFERS_FOR_COPIES;
	return available <= 0 ? 0 : (size_t)available * CONFIG_NET_BUF_DATA_SIZE;
}

#else

size_t lf_send_room(void)
{
	return SIZE_MAX;
}

#endif

/*
 * The poll that zsock_poll() and zsock_select() are made of. Zephyr declares it in no header, but zsock_poll()
 * counts in milliseconds, which is too coarse for the event loop.
 */
int zvfs_poll_internal(struct zvfs_pollfd *fds, int nfds, k_timeout_t timeout);

int lf_poll(struct zsock_pollfd *sockets, int count, int64_t timeout_ticks)
{
	k_timeout_t timeout = timeout_ticks < 0 ? K_FOREVER : K_TICKS(timeout_ticks);

#ifdef CONFIG_NET_NATIVE_OFFLOADED_SOCKETS
	/*
	 * The simulated driver looks at its sockets one simulated microsecond after a poll began, and simulated time
	 * passes only while the processor waits. So a poll that does not wait would never find anything.
	 */
	timeout.ticks = timeout_ticks < 0 ? timeout.ticks : MAX(timeout.ticks, k_us_to_ticks_ceil64(2));
#endif

	return zvfs_poll_internal(sockets, count, timeout);
}

uint32_t lf_cycles_per_second(void)
{
	return (uint32_t)sys_clock_hw_cycles_per_sec();
}

uint32_t lf_interrupts_lock(void)
{
	return irq_lock();
}

void lf_interrupts_unlock(uint32_t key)
{
	irq_unlock(key);
}

int lf_random(uint8_t *buffer, size_t size)
{
#if defined(CONFIG_ARCH_POSIX)
	/* The simulated entropy driver returns the same numbers in every run. */
	int file = nsi_host_open("/dev/urandom", 0);
	long got = file < 0 ? -1 : nsi_host_read(file, buffer, size);

	if (file >= 0) {
		(void)nsi_host_close(file);
	}
	return got == (long)size ? 0 : -EIO;
#elif defined(CONFIG_LF_AUTHENTICATION) || defined(CONFIG_LF_SECURITY)
	return sys_csrand_get(buffer, size);
#else
	ARG_UNUSED(buffer);
	ARG_UNUSED(size);
	return -ENOTSUP;
#endif
}

/* The level selects a macro, not an argument, because Zephyr removes the messages of levels that are off. */
void lf_log(uint32_t level, const char *message)
{
	switch (level) {
	case LOG_LEVEL_ERR:
		LOG_ERR("%s", message);
		break;
	case LOG_LEVEL_WRN:
		LOG_WRN("%s", message);
		break;
	case LOG_LEVEL_INF:
		LOG_INF("%s", message);
		break;
	default:
		LOG_DBG("%s", message);
		break;
	}
}
