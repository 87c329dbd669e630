/* SPDX-License-Identifier: Apache-2.0 */
/* Lines for people: on standard output on Linux, on the console of a board. Lines of several threads do not mix. */
#ifndef LF_PRINT_H_
#define LF_PRINT_H_

#include <stdarg.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LOG_LEVEL_ERROR   0
#define LOG_LEVEL_WARNING 1
#define LOG_LEVEL_INFO    2
#define LOG_LEVEL_LOG     3
#define LOG_LEVEL_DEBUG   4
#define LOG_LEVEL_ALL     255

/* The level of the target property `logging`; messages of more detail are not printed. */
#if !defined(LOG_LEVEL) && !defined(__ZEPHYR__)
#define LOG_LEVEL LOG_LEVEL_INFO
#endif
#ifndef LF_LOG_LEVEL
#ifdef __ZEPHYR__
#define LF_LOG_LEVEL LOG_LEVEL_INFO
#else
#define LF_LOG_LEVEL LOG_LEVEL
#endif
#endif

#define LF_PRINTF_(format, arguments)              __attribute__((__format__(__printf__, format, arguments)))
#define ATTRIBUTE_FORMAT_PRINTF(format, arguments) LF_PRINTF_(format, arguments)

/* One line each, with "LOG: ", "DEBUG: ", "WARNING: ", "ERROR: " or "FATAL ERROR: " before it, or nothing. */
void lf_print(const char *format, ...) LF_PRINTF_(1, 2);
void lf_print_info(const char *format, ...) LF_PRINTF_(1, 2);
void lf_print_log(const char *format, ...) LF_PRINTF_(1, 2);
void lf_print_debug(const char *format, ...) LF_PRINTF_(1, 2);
void lf_print_warning(const char *format, ...) LF_PRINTF_(1, 2);
void lf_print_error(const char *format, ...) LF_PRINTF_(1, 2);
void lf_vprint(const char *format, va_list arguments) LF_PRINTF_(1, 0);
void lf_vprint_info(const char *format, va_list arguments) LF_PRINTF_(1, 0);
void lf_vprint_log(const char *format, va_list arguments) LF_PRINTF_(1, 0);
void lf_vprint_debug(const char *format, va_list arguments) LF_PRINTF_(1, 0);
void lf_vprint_warning(const char *format, va_list arguments) LF_PRINTF_(1, 0);
void lf_vprint_error(const char *format, va_list arguments) LF_PRINTF_(1, 0);

/* The same, and the end of the program, with a status that says so. The second also prints what errno means. */
void lf_print_error_and_exit(const char *format, ...) LF_PRINTF_(1, 2) __attribute__((__noreturn__));
void lf_print_error_system_failure(const char *format, ...) LF_PRINTF_(1, 2) __attribute__((__noreturn__));

/* Messages up to this level go to a function of the program instead; NULL undoes it. */
typedef void(print_message_function_t)(const char *format, va_list arguments);
void lf_register_print_function(print_message_function_t *function, int log_level);

#define LF_PRINT_AT_(level, print, ...)                                                                                \
	do {                                                                                                           \
		if ((level) <= LF_LOG_LEVEL) {                                                                         \
			print(__VA_ARGS__);                                                                            \
		}                                                                                                      \
	} while (0)
#define LF_PRINT_LOG(...)   LF_PRINT_AT_(3, lf_print_log, __VA_ARGS__)
#define LF_PRINT_DEBUG(...) LF_PRINT_AT_(4, lf_print_debug, __VA_ARGS__)

/* Ends the program unless the condition holds. */
#define LF_TEST(condition, format, ...)                                                                                \
	do {                                                                                                           \
		if (!(condition)) {                                                                                    \
			lf_print_error_and_exit(format " (%s:%d: " #condition ")", ##__VA_ARGS__, __FILE__, __LINE__); \
		}                                                                                                      \
	} while (0)

/* The same; without the check, but not without the condition, where NDEBUG is defined. */
#ifdef NDEBUG
#define LF_ASSERT(condition, ...)   ((void)(condition))
#define LF_ASSERTN(condition, ...)  ((void)(condition))
#define LF_ASSERT_NON_NULL(pointer) ((void)(pointer))
#else
#define LF_ASSERT(condition, ...)   LF_TEST(condition, __VA_ARGS__)
#define LF_ASSERTN(condition, ...)  LF_TEST(!(condition), __VA_ARGS__)
#define LF_ASSERT_NON_NULL(pointer) LF_TEST((pointer) != NULL, "out of memory")
#endif

#ifdef __cplusplus
}
#endif

#endif /* LF_PRINT_H_ */
