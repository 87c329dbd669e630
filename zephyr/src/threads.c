/* SPDX-License-Identifier: Apache-2.0 */
/* The threads for physical actions. Their stacks are macros of Zephyr, so C has to define them. */

#include <lf/platform.h>

#if CONFIG_LF_USER_THREADS > 0

static struct k_thread threads[CONFIG_LF_USER_THREADS];
static bool used[CONFIG_LF_USER_THREADS];
static K_THREAD_STACK_ARRAY_DEFINE(stacks, CONFIG_LF_USER_THREADS, CONFIG_LF_USER_THREAD_STACK_SIZE);

static void run(void *entry, void *index, void *unused)
{
	ARG_UNUSED(unused);
	((void (*)(size_t))entry)((size_t)(uintptr_t)index);
}

void lf_thread_start(size_t index, void (*entry)(size_t index))
{
	if (used[index]) {
		/* The thread itself marked its place free, and has its stack in use until it has ended. */
		(void)k_thread_join(&threads[index], K_FOREVER);
	}
	used[index] = true;
	(void)k_thread_create(&threads[index], stacks[index], K_THREAD_STACK_SIZEOF(stacks[index]), run, (void *)entry,
			      (void *)(uintptr_t)index, NULL, K_PRIO_PREEMPT(CONFIG_LF_USER_THREAD_PRIORITY), 0,
			      K_NO_WAIT);
	(void)k_thread_name_set(&threads[index], "lf_user");
}

#else

void lf_thread_start(size_t index, void (*entry)(size_t index))
{
	ARG_UNUSED(index);
	ARG_UNUSED(entry);
}

#endif
