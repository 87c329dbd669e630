/* SPDX-License-Identifier: Apache-2.0 */
#include "sensor_simulator.h"

#include <curses.h>
#include <pthread.h>
#include <unistd.h>

#undef LF_MICRO
#include <lf.h>

#define KEYS    128
/* The time that the thread waits for a key before it checks whether it has to end. */
#define WAIT_MS 100

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static bool is_running;
static pthread_t keyboard;
static FILE *log_to;
static WINDOW *ticks, *messages;
static void *actions[KEYS];
static SCREEN *screen;

/* Shows a message below the lines that stay, or writes it to the log. */
static void print(const char *format, va_list arguments)
{
	pthread_mutex_lock(&mutex);
	if (log_to != NULL) {
		(void)vfprintf(log_to, format, arguments);
		(void)fputc('\n', log_to);
		(void)fflush(log_to);
	} else if (messages != NULL) {
		(void)vw_printw(messages, format, arguments);
		(void)waddch(messages, '\n');
		(void)wrefresh(messages);
	}
	pthread_mutex_unlock(&mutex);
}

static void *read_keys(void *unused)
{
	(void)unused;
	for (;;) {
		int key;
		void *own = NULL, *any;

		pthread_mutex_lock(&mutex);
		if (!is_running) {
			pthread_mutex_unlock(&mutex);
			return NULL;
		}
		key = messages == NULL ? ERR : wgetch(messages);
		if (key == '\r') {
			key = '\n';
		}
		if (key > 0 && key < KEYS) {
			own = actions[key];
		}
		any = key == ERR ? NULL : actions[0];
		pthread_mutex_unlock(&mutex);
		if (own != NULL) {
			(void)lf_schedule_copy(own, 0, &(char){(char)key}, 1);
		}
		if (any != NULL) {
			(void)lf_schedule_copy(any, 0, &(char){(char)key}, 1);
		}
		if (key == ERR) {
			(void)usleep(WAIT_MS * 100);
		}
	}
}

int start_sensor_simulator(const char *message_lines[], int number_of_lines, int tick_window_width, char *log_file,
			   int log_level)
{
	int result = 0;

	pthread_mutex_lock(&mutex);
	if (is_running) {
		goto done;
	}
	if (log_file != NULL) {
		log_to = fopen(log_file, "w");
		if (log_to == NULL) {
			lf_print_error("%s: %s", log_file, strerror(errno));
			result = -1;
			goto done;
		}
	}
	screen = isatty(STDOUT_FILENO) ? newterm(NULL, stdout, stdin) : NULL;
	if (screen == NULL) {
		lf_print_error("start_sensor_simulator: the standard output is no terminal");
		result = -1;
		goto done;
	}
	(void)cbreak();
	(void)noecho();
	(void)curs_set(0);
	for (int line = 0; line < number_of_lines; line++) {
		(void)mvprintw(line, 0, "%s", message_lines[line]);
	}
	(void)refresh();
	if (tick_window_width > 0) {
		ticks = newwin(LINES, tick_window_width, 0, COLS - tick_window_width);
		(void)scrollok(ticks, TRUE);
	}
	messages = newwin(LINES - number_of_lines, COLS - tick_window_width, number_of_lines, 0);
	(void)scrollok(messages, TRUE);
	(void)keypad(messages, TRUE);
	(void)nodelay(messages, TRUE);
	is_running = true;
	lf_register_print_function(print, log_level);
	if (pthread_create(&keyboard, NULL, read_keys, NULL) != 0) {
		is_running = false;
		result = -1;
	}
	(void)atexit(end_sensor_simulator);
done:
	pthread_mutex_unlock(&mutex);
	return result;
}

void end_sensor_simulator(void)
{
	bool was_running;

	pthread_mutex_lock(&mutex);
	was_running = is_running;
	is_running = false;
	pthread_mutex_unlock(&mutex);
	if (!was_running) {
		return;
	}
	(void)pthread_join(keyboard, NULL);
	lf_register_print_function(NULL, LOG_LEVEL_INFO);
	(void)endwin();
	delscreen(screen);
	ticks = messages = NULL;
	if (log_to != NULL) {
		(void)fclose(log_to);
		log_to = NULL;
	}
}

void show_tick(const char *character)
{
	pthread_mutex_lock(&mutex);
	if (ticks != NULL) {
		(void)wprintw(ticks, "%s", character);
		(void)wrefresh(ticks);
	}
	pthread_mutex_unlock(&mutex);
}

int register_sensor_key(char key, void *action)
{
	int result = 0;

	if (action == NULL) {
		return 3;
	}
	if (key != '\n' && key != '\0' && (key < ' ' || key > '~')) {
		return 2;
	}
	pthread_mutex_lock(&mutex);
	if (actions[(int)key] != NULL) {
		result = 1;
	} else {
		actions[(int)key] = action;
	}
	pthread_mutex_unlock(&mutex);
	return result;
}
