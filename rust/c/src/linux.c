/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of the system, on Linux. */

#include "lf_internal.h"

#include <time.h>
#include <unistd.h>

/* ---- For the other files ---- */

void lf_c_begin(void)
{
	/* A reader of a pipe sees each line when it is printed. */
	(void)setvbuf(stdout, NULL, _IOLBF, 0);
}

lf_token_t *lf_c_store_take(size_t bytes)
{
	return (lf_token_t *)calloc(1, LF_TOKEN_SIZE_ + bytes);
}

void lf_c_store_give(lf_token_t *token)
{
	free(token);
}

const char *lf_c_store_advice(void)
{
	return "the computer has none";
}

void *lf_c_allocate(size_t bytes)
{
	return malloc(bytes);
}

void lf_c_free(void *value)
{
	free(value);
}

size_t lf_c_count(size_t *count, int by)
{
	return __atomic_add_fetch(count, (size_t)(ptrdiff_t)by, __ATOMIC_ACQ_REL);
}

__thread void *lf_running_;
/* Rust calls them, too. */
extern inline void *lf_c_running(void);
extern inline void lf_c_set_running(void *running);

instant_t lf_c_clock(void)
{
	struct timespec now;

	(void)clock_gettime(CLOCK_REALTIME, &now);
	return SEC(now.tv_sec) + now.tv_nsec;
}

void lf_c_print_line(const char *prefix, const char *format, va_list arguments)
{
	flockfile(stdout);
	(void)fputs(prefix, stdout);
	(void)vfprintf(stdout, format, arguments);
	(void)fputc('\n', stdout);
	funlockfile(stdout);
}

void lf_c_exit(void)
{
	exit(EXIT_FAILURE);
}

/* ---- Threads ---- */

int lf_thread_create(lf_thread_t *thread, void *(*run)(void *), void *argument)
{
	return pthread_create(thread, NULL, run, argument);
}

int lf_thread_join(lf_thread_t thread, void **result)
{
	return pthread_join(thread, result);
}

lf_thread_t lf_thread_self(void)
{
	return pthread_self();
}

int lf_available_cores(void)
{
	return (int)sysconf(_SC_NPROCESSORS_ONLN);
}

int lf_mutex_init(lf_mutex_t *mutex)
{
	pthread_mutexattr_t attributes;

	(void)pthread_mutexattr_init(&attributes);
	(void)pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_RECURSIVE);
	int result = pthread_mutex_init(mutex, &attributes);
	(void)pthread_mutexattr_destroy(&attributes);
	return result;
}

int lf_mutex_lock(lf_mutex_t *mutex)
{
	return pthread_mutex_lock(mutex);
}

int lf_mutex_unlock(lf_mutex_t *mutex)
{
	return pthread_mutex_unlock(mutex);
}

int lf_cond_init(lf_cond_t *condition, lf_mutex_t *mutex)
{
	condition->mutex = mutex;
	return pthread_cond_init(&condition->condition, NULL);
}

int lf_cond_signal(lf_cond_t *condition)
{
	return pthread_cond_signal(&condition->condition);
}

int lf_cond_broadcast(lf_cond_t *condition)
{
	return pthread_cond_broadcast(&condition->condition);
}

int lf_cond_wait(lf_cond_t *condition)
{
	return pthread_cond_wait(&condition->condition, condition->mutex);
}

int lf_cond_timedwait(lf_cond_t *condition, instant_t until)
{
	/* The program's clock may be corrected, the system's is not. */
	instant_t on_system = lf_time_add(until, lf_c_clock() - lf_time_physical());
	struct timespec time = {.tv_sec = on_system / BILLION, .tv_nsec = on_system % BILLION};

	int result = pthread_cond_timedwait(&condition->condition, condition->mutex, &time);
	return result == ETIMEDOUT ? LF_TIMEOUT : result;
}

static pthread_mutex_t critical = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;

int lf_c_critical_section_enter(void)
{
	return pthread_mutex_lock(&critical);
}

int lf_c_critical_section_exit(void)
{
	return pthread_mutex_unlock(&critical);
}

int lf_sleep(interval_t duration)
{
	if (duration <= 0) {
		return 0;
	}
	struct timespec rest = {.tv_sec = duration / BILLION, .tv_nsec = duration % BILLION};
	while (nanosleep(&rest, &rest) != 0) {
		if (errno != EINTR) {
			return errno;
		}
	}
	return 0;
}
