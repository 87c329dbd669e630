/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Values of variables from a row of a file, in which a character separates the values.
 *
 * The functions read the row with this number, from 0 on, into the variables behind the pointers, of which NULL is the
 * last. They return the number of values, or -1 if the file or the row does not exist, or one of the values is wrong;
 * a line on the console says what it was.
 */
#ifndef LF_INITIALIZE_FROM_FILE_H_
#define LF_INITIALIZE_FROM_FILE_H_

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

int lf_initialize_double(const char *filename, char delimiter, size_t row_number, ...);
int lf_initialize_int(const char *filename, char delimiter, size_t row_number, ...);
/* The texts live as long as the program. */
int lf_initialize_string(const char *filename, char delimiter, size_t row_number, ...);

#ifdef __cplusplus
}
#endif

#endif /* LF_INITIALIZE_FROM_FILE_H_ */
