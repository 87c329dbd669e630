/* SPDX-License-Identifier: Apache-2.0 */
/* Where everything lies, and which body a reaction has. */
#include "program.h"

#define PORT(type_, name, id_, element, ...)                                                                           \
	static type_ name = {                                                                                          \
		.type = {.element_size = sizeof(element)},                                                             \
		.info = &(const lf_cell_info_t){.id = (id_),                                                           \
						.value_offset = offsetof(type_, value),                                \
						.value_size = sizeof(name.value),                                      \
						__VA_ARGS__},                                                          \
	}

PORT(int_port_t, y, 0, int, .readers = 2);
PORT(int_port_t, m_0, 1, int, .readers = 1);
PORT(int_port_t, m_1, 2, int, .readers = 1);
PORT(ints_port_t, list, 3, int, .readers = 4, .is_token = true);
PORT(box_port_t, box, 4, box_t, .readers = 2, .is_token = true);
PORT(grid_port_t, grid, 5, int[3], .readers = 1);
PORT(ints_port_t, doubled, 6, int, .readers = 1, .is_token = true);
PORT(ints_port_t, late, 7, int, .readers = 1, .is_token = true);
PORT(text_port_t, text, 8, string, .readers = 1, .is_string = true);
PORT(ints_port_t, numbers, 9, int, .readers = 1, .is_token = true);
PORT(point_port_t, point, 10, point_t, .readers = 1);
PORT(int_port_t, copied, 11, int, .readers = 1);
PORT(text_port_t, text_out, 12, string, .readers = 1, .is_string = true);
PORT(point_port_t, point_out, 13, point_t, .readers = 1);
PORT(int_action_t, again, 3, int);
PORT(ints_action_t, items, 4, int, .is_token = true);
PORT(int_action_t, button, 5, int);
static lf_timer_t t = {.info = &(const lf_cell_info_t){.id = 2}};
static lf_watchdog_t poodle = {.info = &(const lf_cell_info_t){.id = 6}};
static lf_action_base_t tick = {.info = &(const lf_cell_info_t){.id = 12}};

LF_POOL(queue_7, 3 * sizeof(int), 3);
LF_POOL(queue_10, sizeof(point_t), 4);

#define PORT_AT(name) ((lf_port_base_t *)&(name))
#define TRIGGER_AT(name) ((lf_action_base_t *)&(name))
lf_port_base_t *const lf_ports[] = {
	PORT_AT(y),       PORT_AT(m_0),  PORT_AT(m_1),  PORT_AT(list),    PORT_AT(box),   PORT_AT(grid),   PORT_AT(doubled),
	PORT_AT(late),    PORT_AT(text), PORT_AT(numbers), PORT_AT(point), PORT_AT(copied), PORT_AT(text_out),
	PORT_AT(point_out),
};
lf_action_base_t *const lf_triggers[] = {
	NULL, NULL, &t, TRIGGER_AT(again), TRIGGER_AT(items), TRIGGER_AT(button), &poodle, NULL, NULL, NULL, NULL, NULL,
	&tick,
};
lf_pool_t *const lf_queue_pools[] = {
	NULL, NULL, NULL, NULL, NULL, NULL, NULL, &queue_7, NULL, NULL, &queue_10, NULL, NULL,
};

static Source_self_t source;
static Sink_self_t reader, writer, modal, network;

void lf_construct(void)
{
	source = (Source_self_t){.base = {.name = "source", .full_name = "main.source"}, .count = 0};
	reader = writer = modal = network = (Sink_self_t){.n = 0};
	lf_reset_mode(1);
}

void lf_react(uint16_t reaction)
{
	switch (reaction) {
	case 0:
		Source_reaction_1(&source, &button, &box, &poodle);
		break;
	case 1:
		Source_reaction_2(&source, &y, (int_port_t *[]){&m_0, &m_1}, 2, &list, &box, &grid, &again, &items);
		break;
	case 2:
		Source_reaction_3(&source, &again, &items, &button, &poodle, &y);
		break;
	case 3:
		Source_watchdog_1(&source);
		break;
	case 4:
		Reader_reaction_1(&reader, &y, (int_port_t *[]){&m_0, &m_1}, 2, &list, &box, &grid);
		break;
	case 5:
		Writer_reaction_1(&writer, &list, &box, &doubled);
		break;
	case 6:
		Modal_reaction_1(&modal, (lf_mode_change_t){.mode = 1});
		break;
	case 8:
		Modal_reaction_2(&modal, &tick);
		break;
	case 9:
		Modal_reaction_3(&modal, (lf_mode_change_t){.mode = 0, .history = true});
		break;
	case 10:
		Writer_reaction_2(&writer, &doubled, &late, &copied);
		break;
	case 11:
		Network_reaction_1(&network, &text, &numbers, &text_out);
		break;
	case 12:
		Network_reaction_2(&network, &point, &point_out);
		break;
	case 16:
		Source_reaction_4(&source);
		break;
	}
}

void lf_miss_deadline(uint16_t reaction)
{
	if (reaction == 10) {
		Writer_deadline_2(&writer, &doubled, &late, &copied);
	}
}

void lf_handle_tardy(uint16_t reaction)
{
	if (reaction == 12) {
		Network_tardy_2(&network, &point, &point_out);
	}
}

void lf_reset_mode(uint16_t mode)
{
	if (mode == 1) {
		modal.n = 40;
	}
}
