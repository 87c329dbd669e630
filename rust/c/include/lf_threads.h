/* SPDX-License-Identifier: Apache-2.0 */
/* Threads, locks and waiting, the same on Linux and on Zephyr. Functions that give an int give 0, or an error. */
#ifndef LF_THREADS_H_
#define LF_THREADS_H_

#include "lf_time.h"

#ifdef __ZEPHYR__
#include <zephyr/kernel.h>
#else
#include <pthread.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

#ifdef __ZEPHYR__
/* One of the threads of the image, of which there are CONFIG_LF_USER_THREADS. */
typedef struct lf_user_thread *lf_thread_t;
typedef struct k_mutex lf_mutex_t;
typedef struct {
	lf_mutex_t *mutex;
	struct k_condvar condition;
} lf_cond_t;
#else
typedef pthread_t lf_thread_t;
typedef pthread_mutex_t lf_mutex_t;
typedef struct {
	lf_mutex_t *mutex;
	pthread_cond_t condition;
} lf_cond_t;
#endif

/* A wait has ended because its time is over. */
#define LF_TIMEOUT 1

int lf_thread_create(lf_thread_t *thread, void *(*run)(void *), void *argument);
int lf_thread_join(lf_thread_t thread, void **result);
lf_thread_t lf_thread_self(void);
int lf_available_cores(void);

/* Locks can be taken again by the thread that has them. */
int lf_mutex_init(lf_mutex_t *mutex);
int lf_mutex_lock(lf_mutex_t *mutex);
int lf_mutex_unlock(lf_mutex_t *mutex);

int lf_cond_init(lf_cond_t *condition, lf_mutex_t *mutex);
int lf_cond_signal(lf_cond_t *condition);
int lf_cond_broadcast(lf_cond_t *condition);
int lf_cond_wait(lf_cond_t *condition);
/* Waits until that physical time at the latest; returns LF_TIMEOUT then. */
int lf_cond_timedwait(lf_cond_t *condition, instant_t until);
#define _lf_cond_timedwait lf_cond_timedwait

#define LF_MUTEX_INIT(mutex)      LF_ASSERTN(lf_mutex_init(mutex), "a mutex cannot be made")
#define LF_MUTEX_LOCK(mutex)      LF_ASSERTN(lf_mutex_lock(mutex), "a mutex cannot be locked")
#define LF_MUTEX_UNLOCK(mutex)    LF_ASSERTN(lf_mutex_unlock(mutex), "a mutex cannot be unlocked")
#define LF_COND_INIT(cond, mutex) LF_ASSERTN(lf_cond_init(cond, mutex), "a condition cannot be made")
#define LF_COND_SIGNAL(cond)      LF_ASSERTN(lf_cond_signal(cond), "a condition cannot be signalled")
#define LF_COND_BROADCAST(cond)   LF_ASSERTN(lf_cond_broadcast(cond), "a condition cannot be signalled")
#define LF_COND_WAIT(cond)        LF_ASSERTN(lf_cond_wait(cond), "a condition cannot be waited for")

/*
 * A critical section, which excludes other threads (on Zephyr interrupts, too). It can be entered recursively, and has
 * to be short: on Zephyr interrupts wait. The parentheses may name an environment.
 */
#define lf_critical_section_enter(...) lf_c_critical_section_enter()
#define lf_critical_section_exit(...)  lf_c_critical_section_exit()
#define LF_CRITICAL_SECTION_ENTER(...) ((void)lf_c_critical_section_enter())
#define LF_CRITICAL_SECTION_EXIT(...)  ((void)lf_c_critical_section_exit())
int lf_c_critical_section_enter(void);
int lf_c_critical_section_exit(void);

/* Keeps the calling thread from running for so long. */
int lf_sleep(interval_t duration);
#define lf_nanosleep(duration) lf_sleep(duration)

#ifdef __cplusplus
}
#endif

#endif /* LF_THREADS_H_ */
