/* SPDX-License-Identifier: Apache-2.0 */
/* The ends of an image's program: by itself, by an error, or by a fault that the kernel reports. */

#include <lf/platform.h>

#include <zephyr/fatal.h>
#include <zephyr/logging/log_ctrl.h>
#include <zephyr/sys/printk.h>

#ifdef CONFIG_LF_FATAL_REBOOT
#include <zephyr/sys/reboot.h>
#endif

#ifdef CONFIG_ARCH_POSIX
#include <posix_board_if.h>
#endif

/* The exit status of a program that the kernel has stopped; that of a panic of Rust is 101. */
#define STATUS_FAULT 102

#ifdef CONFIG_LF_FATAL_REBOOT

/* The wait works in interrupts and in faults too, and nothing else runs there that could be kept from its work. */
static FUNC_NORETURN void start_again(void)
{
	printk("lf: the system starts again in %d ms\n", CONFIG_LF_REBOOT_DELAY);
	for (int waited_ms = 0; waited_ms < CONFIG_LF_REBOOT_DELAY; waited_ms++) {
		k_busy_wait(USEC_PER_MSEC);
	}
	sys_reboot(SYS_REBOOT_COLD);
}

#endif

/* Prints on the console how the program has ended, and starts the system again if Kconfig asks for that. */
static void end(int status)
{
	LOG_PANIC();
	if (!IS_ENABLED(CONFIG_ARCH_POSIX)) {
		/* There is no one to return a status to. */
		printk("lf: the program ended with status %d\n", status);
	}
#ifdef CONFIG_LF_FATAL_REBOOT
	if (status != 0) {
		start_again();
	}
#endif
#ifdef CONFIG_ARCH_POSIX
	posix_exit(status);
#endif
}

FUNC_NORETURN void lf_exit(int status)
{
	lf_watchdog_stop();
	end(status);
	while (true) {
		k_sleep(K_FOREVER);
	}
}

void lf_log_flush(void)
{
	LOG_PANIC();
}

#if defined(CONFIG_LF_TRACE)
/* Of the crate lf-zephyr, whose header is not among those of this library. */
extern void lf_trace_print(void);
#endif

FUNC_NORETURN void lf_fault(const char *what, const char *advice)
{
	/* Earlier log messages come first. */
	LOG_PANIC();
	printk("lf: %s; %s\n", what, advice);
#if defined(CONFIG_LF_TRACE)
	lf_trace_print();
#endif
	end(STATUS_FAULT);
	k_fatal_halt(K_ERR_KERNEL_PANIC);
}

/* The kernel has printed the registers and the thread; this says it in words and ends as CONFIG_LF_FATAL_* says. */
void k_sys_fatal_error_handler(unsigned int reason, const struct arch_esf *esf)
{
	ARG_UNUSED(esf);
	switch (reason) {
	case K_ERR_STACK_CHK_FAIL:
		lf_fault("a stack has overflowed",
			 "raise CONFIG_MAIN_STACK_SIZE if reactions ran, CONFIG_LF_USER_THREAD_STACK_SIZE if a thread "
			 "for physical actions did, else the stack of the thread that is named above");
	case K_ERR_KERNEL_OOPS:
	case K_ERR_KERNEL_PANIC:
		lf_fault("the kernel has found an error", "the lines above say which");
	case K_ERR_SPURIOUS_IRQ:
		lf_fault("an interrupt came that nobody handles", "a driver is missing or wrongly configured");
	default:
		lf_fault("the processor has found an error",
			 "the lines above say where; a stack that is too small can cause it");
	}
}
