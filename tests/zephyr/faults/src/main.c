/* SPDX-License-Identifier: Apache-2.0 */
/* A program that ends with an error of its own after a time, unless something else goes wrong before. */

#include <lf/lf.h>
#include <lf/platform.h>

#if defined(CONFIG_TEST_FAULT_STARVED)

#define STACK_SIZE 1024

/* It comes before the event loop, and never lets it go on; interrupts it cannot keep from coming. */
static void keep_busy(void *unused_1, void *unused_2, void *unused_3)
{
	ARG_UNUSED(unused_1);
	ARG_UNUSED(unused_2);
	ARG_UNUSED(unused_3);
	while (true) {
		k_busy_wait(USEC_PER_MSEC);
	}
}

K_THREAD_DEFINE(busy, STACK_SIZE, keep_busy, NULL, NULL, NULL, K_PRIO_COOP(1), 0, 200);

#elif defined(CONFIG_TEST_FAULT_OVERFLOW)

/* Takes stack until there is none. Each call uses what its caller has, so the compiler cannot make a loop of it. */
static __noinline int deeper(volatile char *above, int depth)
{
	volatile char place[64] = {0};
	int below;

	place[depth % sizeof(place)] = 1;
	/* Where the end of the stack is only looked at when threads change, they have to. */
	k_usleep(1);
	below = depth > 1000000 ? 0 : deeper(place, depth + 1);
	return below + place[0] + above[0];
}

#endif

int main(void)
{
	printk("the program begins\n");
#if defined(CONFIG_TEST_FAULT_KERNEL)
	k_panic();
#elif defined(CONFIG_TEST_FAULT_OVERFLOW)
	volatile char top = 0;

	printk("%d\n", deeper(&top, 0));
#endif
	lf_stop(lf_main());
}
