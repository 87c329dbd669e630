/* SPDX-License-Identifier: Apache-2.0 */
/* Lines for people. */

#include "lf_internal.h"

static print_message_function_t *redirected;
static int redirected_level = -1;

void lf_register_print_function(print_message_function_t *function, int log_level)
{
	redirected = function;
	redirected_level = log_level;
}

static void LF_PRINTF_(3, 0) print(int level, const char *prefix, const char *format, va_list arguments)
{
	if (level > LF_MAX(LF_LOG_LEVEL, redirected_level)) {
		return;
	}
	if (redirected != NULL) {
		redirected(format, arguments);
	} else {
		lf_c_print_line(prefix, format, arguments);
	}
}

/* The functions of one level: with arguments, and with a list of them. */
#define PRINTS(name, level, prefix)                                                                                    \
	void lf_v##name(const char *format, va_list arguments)                                                         \
	{                                                                                                              \
		print(level, prefix, format, arguments);                                                               \
	}                                                                                                              \
	void lf_##name(const char *format, ...)                                                                        \
	{                                                                                                              \
		va_list arguments;                                                                                     \
		va_start(arguments, format);                                                                           \
		print(level, prefix, format, arguments);                                                               \
		va_end(arguments);                                                                                     \
	}

PRINTS(print, LOG_LEVEL_INFO, "")
PRINTS(print_info, LOG_LEVEL_INFO, "")
PRINTS(print_log, LOG_LEVEL_LOG, "LOG: ")
PRINTS(print_debug, LOG_LEVEL_DEBUG, "DEBUG: ")
PRINTS(print_warning, LOG_LEVEL_WARNING, "WARNING: ")
PRINTS(print_error, LOG_LEVEL_ERROR, "ERROR: ")

void lf_print_error_and_exit(const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	print(LOG_LEVEL_ERROR, "FATAL ERROR: ", format, arguments);
	va_end(arguments);
	lf_c_exit();
}

void lf_print_error_system_failure(const char *format, ...)
{
	int error = errno;
	va_list arguments;

	va_start(arguments, format);
	print(LOG_LEVEL_ERROR, "ERROR: ", format, arguments);
	va_end(arguments);
	lf_print_error_and_exit("Error %d: %s", error, strerror(error));
}
