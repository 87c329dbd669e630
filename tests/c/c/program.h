/* SPDX-License-Identifier: Apache-2.0 */
/* The types of the program: a struct per reactor, port and action. */
#include <lf.h>

#include "reactor.h"

typedef struct {
	int8_t id;
	double volts;
} point_t;

typedef struct {
	char *name;
	int size;
} box_t;

/* What the bodies have noted, for the test. */
void note(const char *format, ...) LF_PRINTF_(1, 2);
#define NOTE(format, ...)                                                                                              \
	note("%d.%u " format, (int)(lf_time_logical_elapsed() / MSEC(1)), lf_tag(self->base.environment).microstep,    \
	     ##__VA_ARGS__)

typedef struct {
	LF_PORT_BASE;
	int value;
} int_port_t;
typedef struct {
	LF_PORT_BASE;
	int *value;
} ints_port_t;
typedef struct {
	LF_PORT_BASE;
	int value[3];
} grid_port_t;
typedef struct {
	LF_PORT_BASE;
	box_t *value;
} box_port_t;
typedef struct {
	LF_PORT_BASE;
	string value;
} text_port_t;
typedef struct {
	LF_PORT_BASE;
	point_t value;
} point_port_t;
typedef struct {
	LF_ACTION_BASE;
	int value;
} int_action_t;
typedef struct {
	LF_ACTION_BASE;
	int *value;
} ints_action_t;

typedef struct {
	lf_self_base_t base;
	int count;
} Source_self_t;
typedef struct {
	lf_self_base_t base;
	int n;
} Sink_self_t;

/* source */
void Source_reaction_1(Source_self_t *self, int_action_t *button, box_port_t *box, lf_watchdog_t *poodle);
void Source_reaction_2(Source_self_t *self, int_port_t *y, int_port_t **m, int m_width, ints_port_t *list,
		       box_port_t *box, grid_port_t *grid, int_action_t *again, ints_action_t *items);
void Source_reaction_3(Source_self_t *self, int_action_t *again, ints_action_t *items, int_action_t *button,
		       lf_watchdog_t *poodle, int_port_t *y);
void Source_watchdog_1(Source_self_t *self);
void Source_reaction_4(Source_self_t *self);
/* reader */
void Reader_reaction_1(Sink_self_t *self, int_port_t *y, int_port_t **m, int m_width, ints_port_t *list,
		       box_port_t *box, grid_port_t *grid);
/* writer */
void Writer_reaction_1(Sink_self_t *self, const ints_port_t *list_, box_port_t *box, ints_port_t *doubled);
void Writer_reaction_2(Sink_self_t *self, const ints_port_t *doubled_, ints_port_t *late, int_port_t *copied);
void Writer_deadline_2(Sink_self_t *self, const ints_port_t *doubled_, ints_port_t *late, int_port_t *copied);
/* modal */
void Modal_reaction_1(Sink_self_t *self, lf_mode_change_t Two);
void Modal_reaction_2(Sink_self_t *self, lf_action_base_t *tick);
void Modal_reaction_3(Sink_self_t *self, lf_mode_change_t One);
/* network */
void Network_reaction_1(Sink_self_t *self, text_port_t *text, ints_port_t *numbers, text_port_t *text_out);
void Network_reaction_2(Sink_self_t *self, point_port_t *point, point_port_t *point_out);
void Network_tardy_2(Sink_self_t *self, point_port_t *point, point_port_t *point_out);
