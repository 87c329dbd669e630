/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One fault after the other. Where the system starts again after each, it remembers which one is next; where it halts,
 * the program's own error comes first, and a stack overflow in a thread that goes on when the program has ended.
 */

#include <lf/lf.h>
#include <lf/platform.h>

#include <stdlib.h>

#ifdef CONFIG_ARCH_POSIX
#include <nsi_host_trampolines.h>
#endif

enum fault {
	OWN_ERROR,
	PANIC,
	KERNEL_PANIC,
	STARVED,
	STACK_OVERFLOW,
	ALL_HAPPENED,
};

#ifdef CONFIG_ARCH_POSIX

/* A program of the computer starts anew, in its old environment. */
static enum fault next_fault(void)
{
	const char *said = nsi_host_getenv("LF_TEST_NEXT_FAULT");
	enum fault now = said == NULL ? OWN_ERROR : (enum fault)(said[0] - '0');
	char next[2] = {(char)('1' + now), '\0'};

	(void)nsi_host_setenv("LF_TEST_NEXT_FAULT", next, 1);
	/* Its stacks are the computer's, so none of them overflows here. */
	return now == STACK_OVERFLOW ? ALL_HAPPENED : now;
}

#else

#define MARK 0x6c66u

/* Memory that is not initialised outlives a reset. */
static __noinit uint32_t mark;
static __noinit enum fault next;

static enum fault next_fault(void)
{
	if (mark != MARK) {
		mark = MARK;
		next = OWN_ERROR;
	}
	return next++;
}

#endif

static enum fault fault;

bool test_panics(void)
{
	return fault == PANIC;
}

/* Takes stack until there is none. Each call uses what its caller has, so the compiler cannot make a loop of it. */
static __noinline int deeper(volatile char *above, int depth)
{
	volatile char place[64] = {0};
	int below;

	place[depth % sizeof(place)] = 1;
	below = depth > 1000000 ? 0 : deeper(place, depth + 1);
	return below + place[0] + above[0];
}

static void overflow(void)
{
	volatile char top = 0;

	printk("%d\n", deeper(&top, 0));
}

#ifdef CONFIG_LF_FATAL_HALT

static void overflow_later(void *unused_1, void *unused_2, void *unused_3)
{
	ARG_UNUSED(unused_1);
	ARG_UNUSED(unused_2);
	ARG_UNUSED(unused_3);
	printk("the program has halted, and the kernel has not\n");
	overflow();
}

/* Long after the program's error. */
K_THREAD_DEFINE(late, 1024, overflow_later, NULL, NULL, NULL, 1, 0, 3000);

#endif

/* It comes before the event loop, and never lets it go on; interrupts it cannot keep from coming. */
static void keep_busy(void *unused_1, void *unused_2, void *unused_3)
{
	ARG_UNUSED(unused_1);
	ARG_UNUSED(unused_2);
	ARG_UNUSED(unused_3);
	k_sleep(K_MSEC(200));
	while (true) {
		k_busy_wait(USEC_PER_MSEC);
	}
}

K_THREAD_DEFINE(busy, 1024, keep_busy, NULL, NULL, NULL, K_PRIO_COOP(1), 0, SYS_FOREVER_MS);

int main(void)
{
	fault = IS_ENABLED(CONFIG_LF_FATAL_HALT) ? OWN_ERROR : next_fault();
	printk("the program begins with fault %d\n", fault);
	switch (fault) {
	case KERNEL_PANIC:
		k_panic();
		break;
	case STARVED:
		k_thread_start(busy);
		break;
	case STACK_OVERFLOW:
		overflow();
		break;
	case ALL_HAPPENED:
		printk("all faults have happened\n");
		lf_exit(0);
	default:
		break;
	}
	lf_exit(lf_main());
}
