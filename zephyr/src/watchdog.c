/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The watchdog of the event loops: a channel of Zephyr's task watchdog for each thread that runs one, and where the
 * system is to start again, the board's own watchdog behind it, which acts when even the kernel's timers are stuck.
 */

#include <lf/platform.h>

#ifdef CONFIG_LF_WATCHDOG

#include <zephyr/device.h>
#include <zephyr/logging/log.h>
#include <zephyr/task_wdt/task_wdt.h>

LOG_MODULE_DECLARE(lf, CONFIG_LF_LOG_LEVEL);

#ifdef CONFIG_TASK_WDT_HW_FALLBACK
#define BOARD_WATCHDOG DEVICE_DT_GET(DT_ALIAS(watchdog0))
#else
#define BOARD_WATCHDOG NULL
#endif

/* Feeding starts a timer of the kernel anew, so it is not done in every turn of an event loop. */
#define FEEDS_PER_PERIOD 4

/* A thread with an event loop. */
struct loop {
	k_tid_t thread;
	int channel;
	/* In ticks since the boot. */
	int64_t next_feed;
};

static struct loop loops[CONFIG_TASK_WDT_CHANNELS];
static K_MUTEX_DEFINE(loops_lock);

static void expired(int channel, void *unused)
{
	ARG_UNUSED(channel);
	ARG_UNUSED(unused);
	lf_fault("the watchdog has acted, because an event loop has not gone on in time",
		 "a reaction takes too long, or CONFIG_LF_WATCHDOG_PERIOD is too short");
}

static struct loop *find(k_tid_t thread)
{
	for (int index = 0; index < CONFIG_TASK_WDT_CHANNELS; index++) {
		if (loops[index].thread == thread) {
			return &loops[index];
		}
	}
	return NULL;
}

static struct loop *begin(void)
{
	static bool is_ready;
	struct loop *loop;

	(void)k_mutex_lock(&loops_lock, K_FOREVER);
	loop = find(NULL);
	if (!is_ready) {
		int error = task_wdt_init(BOARD_WATCHDOG);

		if (error != 0) {
			LOG_ERR("The board's watchdog cannot be used (error %d): there is only that of the kernel",
				error);
			(void)task_wdt_init(NULL);
		}
		is_ready = true;
	}
	if (loop != NULL) {
		loop->channel = task_wdt_add(CONFIG_LF_WATCHDOG_PERIOD, expired, NULL);
		loop->next_feed = 0;
		loop->thread = k_current_get();
	}
	(void)k_mutex_unlock(&loops_lock);
	return loop;
}

int64_t lf_watchdog_feed(void)
{
	const int64_t interval = k_ms_to_ticks_ceil64(CONFIG_LF_WATCHDOG_PERIOD) / FEEDS_PER_PERIOD;
	struct loop *loop = find(k_current_get());
	int64_t now = k_uptime_ticks();

	if (loop == NULL) {
		loop = begin();
	}
	if (loop != NULL && now >= loop->next_feed) {
		(void)task_wdt_feed(loop->channel);
		loop->next_feed = now + interval;
	}
	return (int64_t)CONFIG_LF_WATCHDOG_PERIOD * NSEC_PER_MSEC / FEEDS_PER_PERIOD;
}

void lf_watchdog_end(void)
{
	struct loop *loop = find(k_current_get());

	if (loop != NULL) {
		(void)task_wdt_delete(loop->channel);
		loop->thread = NULL;
	}
}

void lf_watchdog_stop(void)
{
	for (int index = 0; index < CONFIG_TASK_WDT_CHANNELS; index++) {
		if (loops[index].thread != NULL) {
			(void)task_wdt_delete(loops[index].channel);
		}
	}
}

#else

int64_t lf_watchdog_feed(void)
{
	return INT64_MAX;
}

void lf_watchdog_end(void)
{
}

void lf_watchdog_stop(void)
{
}

#endif
