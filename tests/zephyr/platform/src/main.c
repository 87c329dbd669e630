/* SPDX-License-Identifier: Apache-2.0 */
/* The cases are Rust functions of the crate; each returns what is wrong, or NULL. */

#include <zephyr/ztest.h>

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
CASE(another_thread_ends_a_wait)
CASE(a_wake_up_is_not_lost_before_a_wait)
CASE(threads_are_reused_and_limited)
CASE(bytes_go_over_tcp_and_back)
CASE(a_refused_connection_is_reported)
CASE(a_port_in_use_is_reported)
CASE(a_stale_id_is_an_error)
CASE(a_full_table_leaves_connections_waiting)
CASE(long_lines_keep_whole_characters)

ZTEST_SUITE(platform, NULL, NULL, NULL, NULL, NULL);
