/* SPDX-License-Identifier: Apache-2.0 */
/* The terminal instead of sensors: keys schedule actions, and ticks and messages have their places on the screen. */
#ifndef LF_SENSOR_SIMULATOR_H_
#define LF_SENSOR_SIMULATOR_H_

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Takes the terminal, and shows lines that stay at the top left, beside a column for ticks if its width is not 0.
 * Messages of lf_print() and its variants, up to this level, go to the log file, or to the screen if there is none. The
 * terminal is given back at the end of the program. Returns 0, or another number if there is no terminal, or no log.
 * Later calls have no effect.
 */
int start_sensor_simulator(const char *message_lines[], int number_of_lines, int tick_window_width, char *log_file,
			   int log_level);

/* Restores the terminal. */
void end_sensor_simulator(void);

/* Shows a character in the column for ticks. */
void show_tick(const char *character);

/*
 * Has a key schedule a physical action: a character from ' ' to '~', '\n', or '\0' for any key. Returns 0; 1 if the key
 * has an action already; 2 if it is no such key; 3 if there is no action.
 */
int register_sensor_key(char key, void *action);

#ifdef __cplusplus
}
#endif

#endif /* LF_SENSOR_SIMULATOR_H_ */
