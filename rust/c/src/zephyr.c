/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of the system, on Zephyr. */

/* Before the API of bodies, whose macros have names of functions that are declared here. */
#include <lf/platform.h>

#include "lf_internal.h"

#include <zephyr/sys/printk.h>

/* ---- For the other files ---- */

void lf_c_begin(void)
{
}

/* Tokens that no pool of the program is for. */
#if CONFIG_LF_TOKEN_COUNT > 0
LF_POOL(store, CONFIG_LF_TOKEN_SIZE, CONFIG_LF_TOKEN_COUNT);
#endif

lf_token_t *lf_c_store_take(size_t bytes)
{
#if CONFIG_LF_TOKEN_COUNT > 0
	return lf_c_pool_take(&store, bytes);
#else
	ARG_UNUSED(bytes);
	return NULL;
#endif
}

void lf_c_store_give(lf_token_t *token)
{
	/* Each has a pool. */
	ARG_UNUSED(token);
}

const char *lf_c_store_advice(void)
{
	return "raise CONFIG_LF_TOKEN_COUNT (" STRINGIFY(CONFIG_LF_TOKEN_COUNT) "), or, for larger values, "
										"CONFIG_LF_TOKEN_SIZE (" STRINGIFY(
											CONFIG_LF_TOKEN_SIZE) " bytes)";
}

/*
 * The heap, as soon as a body has used it. Nothing else refers to it, so that the linker leaves it out of images whose
 * bodies do not.
 */
static void *(*heap_take)(size_t size);
static void (*heap_give)(void *memory);

static void use_heap(void)
{
	heap_take = (malloc);
	heap_give = free;
}

void *lf_c_malloc(size_t size)
{
	use_heap();
	return (malloc)(size);
}

void *lf_c_calloc(size_t count, size_t size)
{
	use_heap();
	return (calloc)(count, size);
}

void *lf_c_realloc(void *memory, size_t size)
{
	use_heap();
	return (realloc)(memory, size);
}

void *lf_c_allocate(size_t bytes)
{
	return heap_take != NULL ? heap_take(bytes) : NULL;
}

void lf_c_free(void *value)
{
	if (heap_give != NULL) {
		heap_give(value);
	}
}

size_t lf_c_count(size_t *count, int by)
{
	unsigned int key = irq_lock();
	size_t now = *count + (size_t)by;

	*count = now;
	irq_unlock(key);
	return now;
}

static void *running;
static k_tid_t event_loop;

void *lf_c_running(void)
{
	return running != NULL && !k_is_in_isr() && k_current_get() == event_loop ? running : NULL;
}

void lf_c_set_running(void *reaction)
{
	event_loop = k_current_get();
	running = reaction;
}

instant_t lf_c_clock(void)
{
	return (instant_t)k_ticks_to_ns_floor64((uint64_t)k_uptime_ticks());
}

void lf_c_print_line(const char *prefix, const char *format, va_list arguments)
{
	bool in_turn = !k_is_in_isr();

	if (in_turn) {
		(void)k_mutex_lock(&lf_console_lock, K_FOREVER);
	}
	printk("%s", prefix);
	vprintk(format, arguments);
	printk("\n");
	if (in_turn) {
		(void)k_mutex_unlock(&lf_console_lock);
	}
}

void lf_c_exit(void)
{
	lf_exit(EXIT_FAILURE);
}

/* ---- Threads ---- */

struct lf_user_thread {
	bool is_taken;
	k_tid_t thread;
	void *(*run)(void *argument);
	void *argument;
	void *result;
	struct k_sem ended;
};

static struct lf_user_thread threads[MAX(CONFIG_LF_USER_THREADS, 1)];

static void enter(size_t index)
{
	struct lf_user_thread *thread = &threads[index];

	thread->thread = k_current_get();
	thread->result = thread->run(thread->argument);
	thread->is_taken = false;
	k_sem_give(&thread->ended);
}

int lf_thread_create(lf_thread_t *thread, void *(*run)(void *), void *argument)
{
	for (size_t index = 0; index < CONFIG_LF_USER_THREADS; index++) {
		struct lf_user_thread *place = &threads[index];
		(void)lf_c_critical_section_enter();
		bool is_free = !place->is_taken;
		place->is_taken = true;
		(void)lf_c_critical_section_exit();
		if (!is_free) {
			continue;
		}
		place->run = run;
		place->argument = argument;
		(void)k_sem_init(&place->ended, 0, 1);
		lf_thread_start(index, enter);
		*thread = place;
		return 0;
	}
	lf_print_error("lf_thread_create: all of the image's threads (" STRINGIFY(
		CONFIG_LF_USER_THREADS) ") are running: raise n in the target property `platform: {user-threads: n}`, "
					"or set "
					"CONFIG_LF_USER_THREADS");
	return EAGAIN;
}

int lf_thread_join(lf_thread_t thread, void **result)
{
	(void)k_sem_take(&thread->ended, K_FOREVER);
	if (result != NULL) {
		*result = thread->result;
	}
	return 0;
}

lf_thread_t lf_thread_self(void)
{
	for (size_t index = 0; index < ARRAY_SIZE(threads); index++) {
		if (threads[index].is_taken && threads[index].thread == k_current_get()) {
			return &threads[index];
		}
	}
	return NULL;
}

int lf_available_cores(void)
{
	return (int)arch_num_cpus();
}

int lf_mutex_init(lf_mutex_t *mutex)
{
	return k_mutex_init(mutex);
}

int lf_mutex_lock(lf_mutex_t *mutex)
{
	return k_mutex_lock(mutex, K_FOREVER);
}

int lf_mutex_unlock(lf_mutex_t *mutex)
{
	return k_mutex_unlock(mutex);
}

int lf_cond_init(lf_cond_t *condition, lf_mutex_t *mutex)
{
	condition->mutex = mutex;
	return k_condvar_init(&condition->condition);
}

int lf_cond_signal(lf_cond_t *condition)
{
	return k_condvar_signal(&condition->condition);
}

int lf_cond_broadcast(lf_cond_t *condition)
{
	return MIN(k_condvar_broadcast(&condition->condition), 0);
}

int lf_cond_wait(lf_cond_t *condition)
{
	return k_condvar_wait(&condition->condition, condition->mutex, K_FOREVER);
}

int lf_cond_timedwait(lf_cond_t *condition, instant_t until)
{
	interval_t rest = MAX(lf_time_subtract(until, lf_time_physical()), 0);

	int result = k_condvar_wait(&condition->condition, condition->mutex, K_NSEC(rest));
	return result == -EAGAIN ? LF_TIMEOUT : result;
}

/* Interrupts wait meanwhile. */
static unsigned int critical_key;
static unsigned int critical_depth;

int lf_c_critical_section_enter(void)
{
	unsigned int key = irq_lock();

	if (critical_depth++ == 0) {
		critical_key = key;
	}
	return 0;
}

int lf_c_critical_section_exit(void)
{
	if (--critical_depth == 0) {
		irq_unlock(critical_key);
	}
	return 0;
}

int lf_sleep(interval_t duration)
{
	if (duration > 0) {
		(void)k_sleep(K_NSEC(duration));
	}
	return 0;
}
