/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"

typedef struct {
	LF_ACTION_BASE;
	int value;
} button_t;
typedef struct {
	LF_ACTION_BASE;
	point_t *value;
} points_t;
typedef struct {
	lf_self_base_t base;
	int ticks;
	int presses;
} main_self_t;

LF_POOL(button_pool, sizeof(int), 6);

static main_self_t self_;
static lf_timer_t timer = {.info = &(const lf_cell_info_t){.id = 2}};
static button_t button = {
	.type = {.element_size = sizeof(int)},
	.info = &(const lf_cell_info_t){.id = 3,
					.value_offset = offsetof(button_t, value),
					.value_size = sizeof(int),
					.pool = &button_pool},
};
static points_t points = {
	.type = {.element_size = sizeof(point_t)},
	.info = &(const lf_cell_info_t){.id = 4,
					.is_token = true,
					.value_offset = offsetof(points_t, value),
					.value_size = sizeof(point_t *)},
};

lf_port_base_t *const lf_ports[] = {NULL};
lf_action_base_t *const lf_triggers[] = {
	NULL, NULL, &timer, (lf_action_base_t *)&button, (lf_action_base_t *)&points,
};
lf_pool_t *const lf_queue_pools[] = {NULL};

static void *press(void *action)
{
	for (int presses = 1; presses <= 2; presses++) {
		if (lf_schedule_int(action, 0, presses) < 0) {
			lf_print_error("the button is stuck");
		}
	}
	return NULL;
}

/* Runs in an interrupt. */
static void press_in_interrupt(struct k_timer *unused)
{
	ARG_UNUSED(unused);
	if (lf_schedule_int(&button, 0, 3) < 0) {
		lf_print_error("the button is stuck");
	}
}

static K_TIMER_DEFINE(presser, press_in_interrupt, NULL);

static void main_reaction_1(main_self_t *self, button_t *button)
{
	lf_thread_t thread;

	lf_print("%s starts, a point takes %d bytes", lf_reactor_name(self), (int)sizeof(point_t));
	(void)lf_thread_create(&thread, press, button);
	k_timer_start(&presser, K_MSEC(2), K_NO_WAIT);
}

static void main_reaction_2(main_self_t *self, points_t *points)
{
	self->ticks++;
	lf_print("tick %d at %d ms", self->ticks, (int)(lf_time_logical_elapsed() / MSEC(1)));
	if (self->ticks == 2) {
		lf_print_warning("half of the ticks");
	}
	point_t both[] = {{.id = self->ticks}, {.id = self->ticks + 1}};
	lf_schedule_copy(points, MSEC(5), both, 2);
}

static void main_reaction_4(main_self_t *self, points_t *points)
{
	lf_print("points at %d ms: %d, from %d to %d", (int)(lf_time_logical_elapsed() / MSEC(1)), (int)points->length,
		 points->value[0].id, points->value[1].id);
}

static void main_reaction_5(main_self_t *self)
{
	lf_print("shutdown after %d ticks and %d presses", self->ticks, self->presses);
}

void lf_construct(void)
{
	self_ = (main_self_t){.base = {.name = "main", .full_name = "main"}};
}

void lf_react(uint16_t reaction)
{
	switch (reaction) {
	case 0:
		main_reaction_1(&self_, &button);
		break;
	case 1:
		main_reaction_2(&self_, &points);
		break;
	case 2:
		self_.presses++;
		break;
	case 3:
		main_reaction_4(&self_, &points);
		break;
	case 4:
		main_reaction_5(&self_);
		break;
	}
}

void lf_miss_deadline(uint16_t reaction)
{
	ARG_UNUSED(reaction);
}

void lf_handle_tardy(uint16_t reaction)
{
	ARG_UNUSED(reaction);
}

void lf_reset_mode(uint16_t mode)
{
	ARG_UNUSED(mode);
}
