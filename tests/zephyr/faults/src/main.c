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

/* Takes stack until there is none; the sum keeps the compiler from making a loop of it. */
static int deeper(int depth)
{
	volatile char place[64] = {0};

	place[depth % sizeof(place)] = 1;
	/* Where the end of the stack is only looked at when threads change, they have to. */
	k_usleep(1);
	return depth > 1000000 ? 0 : place[0] + deeper(depth + 1);
}

#endif

int main(void)
{
	printk("the program begins\n");
#if defined(CONFIG_TEST_FAULT_KERNEL)
	k_panic();
#elif defined(CONFIG_TEST_FAULT_OVERFLOW)
	printk("%d\n", deeper(0));
#endif
	lf_stop(lf_main());
}
