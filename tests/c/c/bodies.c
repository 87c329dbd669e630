/* SPDX-License-Identifier: Apache-2.0 */
/* The bodies, as users write them, each in its function. */
#include "program.h"

/* ---- preamble ---- */

static int boxes_made, boxes_copied, boxes_destroyed;

static void *copy_box(void *value)
{
	box_t *copy = (box_t *)malloc(sizeof(box_t));
	*copy = *(box_t *)value;
	boxes_copied++;
	return copy;
}

static void destroy_box(void *value)
{
	boxes_destroyed++;
	free(value);
}

static void *press(void *button)
{
	lf_schedule_int(button, MSEC(12), 77);
	return button;
}

/* ---- reactor Source ---- */

void Source_reaction_1(Source_self_t *self, int_action_t *button, box_port_t *box, lf_watchdog_t *poodle)
{
	lf_thread_t thread;
	void *result;

	LF_TEST(lf_thread_create(&thread, press, button) == 0, "no thread");
	LF_TEST(lf_thread_join(thread, &result) == 0 && result == button, "the thread gave %p", result);
	lf_set_destructor(box, destroy_box);
	lf_set_copy_constructor(box, copy_box);
	lf_watchdog_start(poodle, MSEC(1));
	NOTE("%s of %s starts with %s", lf_reactor_name(self), lf_reactor_full_name(self), GREETING);
}

void Source_reaction_2(Source_self_t *self, int_port_t *y, int_port_t **m, int m_width, ints_port_t *list,
		       box_port_t *box, grid_port_t *grid, int_action_t *again, ints_action_t *items)
{
	self->count++;
	lf_set(y, self->count);
	lf_set(m[m_width - 1], 10 * self->count);
	int *numbers = (int *)malloc(3 * sizeof(int));
	for (int i = 0; i < 3; i++) {
		numbers[i] = i + 1;
		grid->value[i] = 100 + i;
	}
	lf_set_array(list, numbers, 3);
	lf_set_present(grid);
	box_t *made = (box_t *)malloc(sizeof(box_t));
	*made = (box_t){.name = "box", .size = 4};
	boxes_made++;
	lf_set(box, made);
	if (self->count == 2) {
		lf_request_stop();
		return;
	}
	lf_schedule_int(again, MSEC(2), 5);
	lf_schedule_copy(items, MSEC(3), (int[]){7, 8}, 2);
	int *single = (int *)malloc(sizeof(int));
	*single = 9;
	lf_schedule_value(items, MSEC(3), single, 1);
	lf_schedule_token(items, MSEC(4), list->token);
	lf_schedule(items, MSEC(4));
}

void Source_reaction_3(Source_self_t *self, int_action_t *again, ints_action_t *items, int_action_t *button,
		       lf_watchdog_t *poodle, int_port_t *y)
{
	if (again->is_present) {
		NOTE("again %d", again->value);
		lf_watchdog_start(poodle, 0);
		lf_set(y, again->value);
	}
	if (items->is_present && items->has_value) {
		NOTE("%zu items from %d", items->length, items->value[0]);
	} else if (items->is_present) {
		NOTE("no items%s", items->token == NULL ? "" : "?");
	}
	if (button->is_present) {
		NOTE("button %d", button->value);
		lf_watchdog_start(poodle, 0);
		lf_watchdog_stop(poodle);
	}
}

void Source_watchdog_1(Source_self_t *self)
{
	NOTE("poodle barks");
}

void Source_reaction_4(Source_self_t *self)
{
	NOTE("ends; %d boxes, %d copies, %d destroyed", boxes_made, boxes_copied, boxes_destroyed);
}

/* ---- reactor Reader ---- */

void Reader_reaction_1(Sink_self_t *self, int_port_t *y, int_port_t **m, int m_width, ints_port_t *list,
		       box_port_t *box, grid_port_t *grid)
{
	lf_multiport_iterator_t iterator = lf_multiport_iterator(m);
	int sum = 0;
	int channel;

	while ((channel = lf_multiport_next(&iterator)) >= 0) {
		sum += channel + m[channel]->value;
	}
	NOTE("y %d m %d list %zu", y->value, sum, list->length);
	if (grid->is_present) {
		NOTE("grid %d %s %d", grid->value[2], box->value->name, list->value[1]);
	}
}

/* ---- reactor Writer: its inputs `list` and `doubled` are mutable ---- */

void Writer_reaction_1(Sink_self_t *self, const ints_port_t *list_, box_port_t *box, ints_port_t *doubled)
{
	ints_port_t copy = *list_, *list = &copy;
	lf_c_make_mutable((lf_port_base_t *)list);
	{
		for (size_t i = 0; i < list->length; i++) {
			list->value[i] *= 2;
		}
		lf_token_t *own = lf_writable_copy(box);
		((box_t *)own->value)->size = 5;
		NOTE("box %d, own %d", box->value->size, ((box_t *)own->value)->size);
		lf_set_token(doubled, list->token);
	}
}

void Writer_reaction_2(Sink_self_t *self, const ints_port_t *doubled_, ints_port_t *late, int_port_t *copied)
{
	ints_port_t copy = *doubled_, *doubled = &copy;
	lf_c_make_mutable((lf_port_base_t *)doubled);
	{
		if (doubled->is_present) {
			NOTE("doubled %d%s", doubled->value[2], doubled->value == doubled_->value ? ", in place" : "");
		}
		if (late->is_present) {
			NOTE("late %d %d %d", late->value[0], late->value[1], late->value[2]);
			/* From now on it is always too late. */
			lf_update_deadline(self, 0);
			NOTE("%s", lf_check_deadline(self, false) ? "late for it" : "in time");
		}
		if (copied->is_present) {
			NOTE("copied %d", copied->value);
		}
	}
}

void Writer_deadline_2(Sink_self_t *self, const ints_port_t *doubled_, ints_port_t *late, int_port_t *copied)
{
	NOTE("deadline missed%s", doubled_->is_present || late->is_present || copied->is_present ? "" : "?");
}

/* ---- reactor Modal ---- */

void Modal_reaction_1(Sink_self_t *self, lf_mode_change_t Two)
{
	NOTE("One");
	lf_set_mode(Two);
}

void Modal_reaction_2(Sink_self_t *self, lf_action_base_t *tick)
{
	NOTE("Two is reset, n %d", self->n);
	self->n++;
	lf_schedule(tick, MSEC(2));
}

void Modal_reaction_3(Sink_self_t *self, lf_mode_change_t One)
{
	NOTE("tick, n %d", self->n);
	lf_set_mode(One);
}

/* ---- reactor Network ---- */

void Network_reaction_1(Sink_self_t *self, text_port_t *text, ints_port_t *numbers, text_port_t *text_out)
{
	NOTE("text %s, %zu numbers to %d", text->value, numbers->length, numbers->value[numbers->length - 1]);
	lf_set(text_out, text->value);
}

void Network_reaction_2(Sink_self_t *self, point_port_t *point, point_port_t *point_out)
{
	NOTE("point %d", point->value.id);
	lf_set(point_out, point->value);
}

void Network_tardy_2(Sink_self_t *self, point_port_t *point, point_port_t *point_out)
{
	NOTE("point %d is tardy, it was meant for %d", point->value.id,
	     (int)((point->intended_tag.time - lf_time_start()) / MSEC(1)));
	lf_set(point_out, ((point_t){.id = 3, .volts = 1.5}));
}
