/* SPDX-License-Identifier: Apache-2.0 */
/* The cases are Rust functions of the crate; each returns what is wrong, or NULL. */

#include <zephyr/ztest.h>

#ifdef CONFIG_ARCH_POSIX
/* The simulated clock stands still while code runs, so this is the computer's. */
uint64_t get_host_us_time(void);

int64_t test_now_ns(void)
{
	return 1000 * (int64_t)get_host_us_time();
}
#else
int64_t test_now_ns(void)
{
	return (int64_t)k_cyc_to_ns_floor64(k_cycle_get_64());
}
#endif

#define CASE(name)                                                                                                     \
	const char *name(void);                                                                                        \
	ZTEST(security, test_##name)                                                                                   \
	{                                                                                                              \
		const char *wrong = name();                                                                            \
                                                                                                                       \
		zassert_is_null(wrong, "%s", wrong == NULL ? "" : wrong);                                              \
	}

CASE(both_ends_prove_who_they_are_and_carry_records)
CASE(a_changed_record_and_a_changed_datagram_are_noticed)

ZTEST_SUITE(security, NULL, NULL, NULL, NULL, NULL);
