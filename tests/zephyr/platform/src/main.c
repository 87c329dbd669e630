/* SPDX-License-Identifier: Apache-2.0 */
/* The cases are Rust functions of the crate; each returns what is wrong, or NULL. */

#include <zephyr/ztest.h>

/* Functions for Rust, because Zephyr has them as macros and inline functions. */

int64_t test_uptime_ticks(void)
{
	return k_uptime_ticks();
}

bool test_has_counter_of_64_bits(void)
{
	return IS_ENABLED(CONFIG_TIMER_HAS_64BIT_CYCLE_COUNTER);
}

void test_interrupted(void);

static void expired(struct k_timer *timer)
{
	ARG_UNUSED(timer);
	test_interrupted();
}

static K_TIMER_DEFINE(wake_timer, expired, NULL);

void test_wake_from_interrupt(void)
{
	k_timer_start(&wake_timer, K_MSEC(5), K_NO_WAIT);
}

#define CASE(name)                                                                                                     \
	const char *name(void);                                                                                        \
	ZTEST(platform, test_##name)                                                                                   \
	{                                                                                                              \
		const char *wrong = name();                                                                            \
                                                                                                                       \
		zassert_is_null(wrong, "%s", wrong == NULL ? "" : wrong);                                              \
	}

CASE(clock_never_runs_backwards)
CASE(conversion_is_exact)
CASE(extension_carries_over_the_wrap)
CASE(extension_is_shared_by_readers)
CASE(wait_ends_at_its_time)
CASE(time_is_exact_over_the_wrap)
CASE(another_thread_ends_a_wait)
CASE(a_wake_up_is_not_lost_before_a_wait)
CASE(an_interrupt_ends_a_wait)
CASE(threads_are_reused_and_limited)
CASE(bytes_go_over_tcp_and_back)
CASE(a_wait_for_a_silent_socket_ends_at_its_time)
CASE(a_full_connection_would_block)
CASE(datagrams_come_with_their_sender)
CASE(a_refused_connection_is_reported)
CASE(a_port_in_use_is_reported)
CASE(a_stale_id_is_an_error)
CASE(a_full_table_leaves_connections_waiting)
#ifdef CONFIG_ARCH_POSIX
/* Twister reads the console of QEMU byte by byte, and takes only characters of one byte. */
CASE(long_lines_keep_whole_characters)
#endif

ZTEST_SUITE(platform, NULL, NULL, NULL, NULL, NULL);
