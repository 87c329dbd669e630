/* SPDX-License-Identifier: Apache-2.0 */
/* Errors, waiting, logging and the end of the program, for the Rust crate lf-zephyr. */

#include <lf/platform.h>

#include <errno.h>

#include <zephyr/irq.h>
#include <zephyr/logging/log.h>
#include <zephyr/logging/log_ctrl.h>
#include <zephyr/sys/printk.h>

#ifdef CONFIG_ARCH_POSIX
#include <nsi_host_trampolines.h>
#include <posix_board_if.h>
#endif

#ifdef CONFIG_LF_AUTHENTICATION
#include <zephyr/random/random.h>

BUILD_ASSERT(IS_ENABLED(CONFIG_ARCH_POSIX) || IS_ENABLED(CONFIG_CSPRNG_ENABLED) ||
		     IS_ENABLED(CONFIG_TEST_CSPRNG_GENERATOR),
	     "authentication needs random numbers: this board has no driver for its entropy source");
#endif

LOG_MODULE_REGISTER(lf, CONFIG_LF_LOG_LEVEL);

/* A socket may be waited for in both directions, each of which takes one entry; the wake-up takes one more. */
BUILD_ASSERT(CONFIG_ZVFS_POLL_MAX >= 2 * CONFIG_LF_SOCKETS + 1,
	     "CONFIG_ZVFS_POLL_MAX must be at least 2 * CONFIG_LF_SOCKETS + 1");
BUILD_ASSERT(CONFIG_ZVFS_OPEN_MAX >= CONFIG_LF_SOCKETS + 1,
	     "CONFIG_ZVFS_OPEN_MAX must be at least CONFIG_LF_SOCKETS + 1");

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
		return LF_NETWORK_UNREACHABLE;
	case EADDRINUSE:
		return LF_NETWORK_ADDRESS_IN_USE;
	case ENFILE:
	case EMFILE:
	case ENOMEM:
	case ENOBUFS:
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
	/* The simulated entropy driver gives the same numbers in every run. */
	int file = nsi_host_open("/dev/urandom", 0);
	long got = file < 0 ? -1 : nsi_host_read(file, buffer, size);

	if (file >= 0) {
		(void)nsi_host_close(file);
	}
	return got == (long)size ? 0 : -EIO;
#elif defined(CONFIG_LF_AUTHENTICATION)
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

void lf_log_flush(void)
{
	LOG_PANIC();
}

FUNC_NORETURN void lf_stop(int status)
{
	lf_log_flush();
#ifdef CONFIG_ARCH_POSIX
	posix_exit(status);
#else
	/* There is no one to return a status to. The line lets a host that reads the console know it. */
	printk("lf: the program ended with status %d\n", status);
	while (true) {
		k_sleep(K_FOREVER);
	}
#endif
}
