/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The part of native_sim's oscilloscope that is a program of the computer: its clock and its files. The clock counts
 * nanoseconds since 1970; the image's own one may drift. It is compiled with the computer's headers, so only types of
 * the language are here.
 */
#ifndef LF_OSCILLOSCOPE_HOST_H_
#define LF_OSCILLOSCOPE_HOST_H_

#include <stdbool.h>
#include <stdint.h>

/* The program starts in this many nanoseconds. */
void lf_oscilloscope_set_start(int64_t in_ns);

/* Returns the nanoseconds since then, by the computer's clock; negative before the start. */
int64_t lf_oscilloscope_elapsed(void);

/* Writes what pins do into this file when the process ends. */
void lf_oscilloscope_record_into(const char *file);

/* A pin has this name in the file, which is copied; returns the number by which it is called from then on. */
unsigned int lf_oscilloscope_add_pin(const char *name);

/* A pin is active now, or is not. */
void lf_oscilloscope_note(unsigned int pin, bool active);

/* A change of an input. */
struct lf_oscilloscope_move {
	/* Nanoseconds since the start. */
	int64_t at;
	bool active;
	/* Where the script says so. */
	unsigned int line;
	char name[64];
};

/* Reads what `lfz moves` has printed; the process ends with an error if it cannot. */
void lf_oscilloscope_read_moves(const char *file);

/* The number of moves, and each of them. */
unsigned int lf_oscilloscope_moves(void);
const struct lf_oscilloscope_move *lf_oscilloscope_move(unsigned int index);

/* Ends the process with an error about a move of a pin that the image does not have. */
void lf_oscilloscope_refuse(const struct lf_oscilloscope_move *move);

#endif
