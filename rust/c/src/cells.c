/* SPDX-License-Identifier: Apache-2.0 */
/* Ports and actions: how values come into them and out of them. */

#include "lf_internal.h"

static unsigned char *value_of(lf_port_base_t *port)
{
	return (unsigned char *)port + port->info->value_offset;
}

/* The pointer that is the value of a port of tokens or texts. */
static void *pointer_of(lf_port_base_t *port)
{
	void *pointer;

	memcpy(&pointer, value_of(port), sizeof(pointer));
	return pointer;
}

static void set_pointer(lf_port_base_t *port, void *pointer)
{
	memcpy(value_of(port), &pointer, sizeof(pointer));
}

/* Sets the token of a port, which owns it, or removes it. */
static void own(lf_port_base_t *port, lf_token_t *token)
{
	lf_token_t *before = port->token;

	port->token = token;
	port->length = token != NULL ? token->length : 0;
	if (before != NULL) {
		lf_c_token_release(before);
	}
}

#ifndef __ZEPHYR__
static const lf_serializer_t *serializer_of(const lf_port_base_t *port)
{
	return port->info->serializer;
}

/* Puts a message into a token; NULL if the bytes are none. */
static lf_token_t *unpack(lf_port_base_t *port, lf_pool_t *pool, const unsigned char *bytes, size_t size)
{
	void *message = serializer_of(port)->unpack(bytes, size);

	return message != NULL ? lf_c_token_for(&port->type, pool, message, 1, LF_VALUE_GIVEN_) : NULL;
}
#endif

static size_t length_of(const lf_port_base_t *port)
{
	return port->token != NULL ? port->token->length : 1;
}

/* ---- The bodies' access to ports ---- */

static inline void set_present(lf_port_base_t *port)
{
	tag_t tag = lf_c_mark_present(lf_c_running(), port->info->id);

	if (!port->is_present) {
		port->is_present = true;
		port->intended_tag = tag;
	}
}

void lf_c_set_present(lf_port_base_t *port)
{
	set_present(port);
}

void *lf_c_set_array(lf_port_base_t *port, void *elements, size_t count)
{
	lf_token_t *token = port->token;

	if (token != NULL && token->value == elements && token->place == LF_VALUE_GIVEN_) {
		/* The same elements once more: they have one owner as before. */
		token->length = count;
		port->length = count;
	} else {
		own(port, lf_c_token_for(&port->type, port->info->pool, elements, count, LF_VALUE_GIVEN_));
	}
	set_present(port);
	return elements;
}

void lf_c_set(lf_port_base_t *port)
{
	if (port->info->is_token) {
		(void)lf_c_set_array(port, pointer_of(port), 1);
	} else {
		if (port->token != NULL) {
			/* A text that came from elsewhere. */
			own(port, NULL);
		}
		set_present(port);
	}
}

void *lf_c_set_token(lf_port_base_t *port, lf_token_t *token)
{
	lf_c_token_retain(token);
	own(port, token);
	set_present(port);
	return token->value;
}

void lf_c_make_mutable(lf_port_base_t *port)
{
	if (port->is_present && port->info->is_token) {
		port->token = lf_c_writable_copy(port);
		if (port->token != NULL) {
			set_pointer(port, port->token->value);
		}
	}
}

int lf_multiport_next(lf_multiport_iterator_t *iterator)
{
	while (iterator->next < iterator->width) {
		int channel = iterator->next++;
		if (iterator->ports[channel]->is_present) {
			return channel;
		}
	}
	return -1;
}

/* ---- The runtime's access to ports ---- */

bool lf_c_port_is_present(uint16_t port)
{
	return lf_ports[port]->is_present;
}

void lf_c_port_fill(uint16_t id, lf_token_t *token, tag_t intended)
{
	lf_port_base_t *port = lf_ports[id];

	port->is_present = true;
	port->intended_tag = intended;
	port->physical_time_of_arrival = token->arrival;
	if (port->info->is_token || port->info->is_string) {
		set_pointer(port, token->value);
		own(port, token);
	} else {
		memcpy(value_of(port), token->value, port->info->value_size);
		lf_c_token_release(token);
	}
}

void lf_c_port_clear(uint16_t id)
{
	lf_port_base_t *port = lf_ports[id];

	port->is_present = false;
	if (port->token != NULL) {
		own(port, NULL);
		set_pointer(port, NULL);
	}
}

void lf_c_port_copy(uint16_t from_id, uint16_t to_id)
{
	lf_port_base_t *from = lf_ports[from_id];
	lf_port_base_t *to = lf_ports[to_id];

	memcpy(value_of(to), value_of(from), LF_MIN(to->info->value_size, from->info->value_size));
	if (from->token != NULL) {
		lf_c_token_retain(from->token);
	}
	own(to, from->token);
	to->is_present = true;
	to->intended_tag = from->intended_tag;
	to->physical_time_of_arrival = from->physical_time_of_arrival;
}

lf_token_t *lf_c_port_capture(uint16_t from_id, uint16_t to_id, uint16_t trigger)
{
	lf_port_base_t *from = lf_ports[from_id];
	lf_port_base_t *to = lf_ports[to_id];
	lf_pool_t *pool = lf_queue_pools[trigger];

	if (from->token != NULL) {
		lf_c_token_retain(from->token);
		return from->token;
	}
	if (from->info->is_token || from->info->is_string) {
		return lf_c_token_for(&to->type, pool, pointer_of(from), 1, LF_VALUE_BORROWED_);
	}
	lf_token_t *token = lf_c_token_with_room(&to->type, pool, 1, to->info->value_size);
	memcpy(token->value, value_of(from), LF_MIN(to->info->value_size, from->info->value_size));
	return token;
}

size_t lf_c_port_encode(uint16_t id, unsigned char *bytes, size_t room)
{
	lf_port_base_t *port = lf_ports[id];
	const void *value = value_of(port);
	size_t size = port->info->value_size;

	if (port->info->is_token || port->info->is_string) {
		value = pointer_of(port);
		if (value == NULL) {
			return 0;
		}
#ifndef __ZEPHYR__
		if (serializer_of(port) != NULL) {
			size = serializer_of(port)->size(value);
			return size <= room ? serializer_of(port)->pack(value, bytes) : size;
		}
#endif
		size = port->info->is_string ? strlen((const char *)value) + 1
					     : port->type.element_size * length_of(port);
	}
	if (size <= room) {
		memcpy(bytes, value, size);
	}
	return size;
}

int lf_c_port_check(uint16_t id, const unsigned char *bytes, size_t size, size_t *expected)
{
	const lf_port_base_t *port = lf_ports[id];

#ifndef __ZEPHYR__
	if (serializer_of(port) != NULL) {
		/* Only unpacking tells. */
		return LF_BYTES_GOOD;
	}
#endif
	if (port->info->is_string) {
		bool ends = size > 0 && memchr(bytes, 0, size) == &bytes[size - 1];
		return ends ? LF_BYTES_GOOD : LF_BYTES_NUL;
	}
	if (port->info->is_token) {
		*expected = port->type.element_size;
		return *expected != 0 && size % *expected == 0 ? LF_BYTES_GOOD : LF_BYTES_REMAINDER;
	}
	*expected = port->info->value_size;
	return size == *expected ? LF_BYTES_GOOD : LF_BYTES_LENGTH;
}

lf_token_t *lf_c_port_decode(uint16_t id, uint16_t trigger, const unsigned char *bytes, size_t size, instant_t arrival)
{
	lf_port_base_t *port = lf_ports[id];
	lf_pool_t *pool = lf_queue_pools[trigger];
	lf_token_t *token;

#ifndef __ZEPHYR__
	if (serializer_of(port) != NULL) {
		token = unpack(port, pool, bytes, size);
		if (token != NULL) {
			token->arrival = arrival;
		}
		return token;
	}
#endif
	if (port->info->is_token) {
		token = lf_c_token_copy(&port->type, pool, bytes, size / port->type.element_size);
	} else {
		token = lf_c_token_with_room(&port->type, pool, 1, size);
		memcpy(token->value, bytes, size);
	}
	token->arrival = arrival;
	return token;
}

/* ---- Actions, timers and watchdogs ---- */

bool lf_c_has_trigger(uint16_t trigger)
{
	return trigger < lf_trigger_count;
}

bool lf_c_shows_trigger(uint16_t trigger)
{
	return lf_c_has_trigger(trigger) && lf_triggers[trigger] != NULL;
}

void lf_c_trigger_show(uint16_t id, lf_token_t *token)
{
	lf_action_base_t *action = lf_triggers[id];

	action->is_present = true;
	action->token = token;
	action->has_value = token != NULL && token->value != NULL;
	action->length = token != NULL ? token->length : 0;
	if (!action->has_value || action->info->value_size == 0) {
		return;
	}
	void *place = (unsigned char *)action + action->info->value_offset;
	if (action->info->is_token) {
		memcpy(place, &token->value, sizeof(token->value));
	} else {
		memcpy(place, token->value,
		       LF_MIN(action->info->value_size, action->type.element_size * token->length));
	}
}

void lf_c_trigger_clear(uint16_t id)
{
	lf_action_base_t *action = lf_triggers[id];

	if (action->token != NULL && action->info->is_token) {
		memset((unsigned char *)action + action->info->value_offset, 0, sizeof(void *));
	}
	action->is_present = false;
	action->has_value = false;
	action->token = NULL;
}

trigger_handle_t lf_schedule(void *action, interval_t offset)
{
	return lf_c_schedule(((lf_action_base_t *)action)->info->id, offset, NULL);
}

trigger_handle_t lf_schedule_int(void *action, interval_t offset, int value)
{
	lf_action_base_t *base = (lf_action_base_t *)action;

	if (base->type.element_size != sizeof(int)) {
		lf_print_error("lf_schedule_int: the action's type takes %zu bytes, and an int %zu: use "
			       "lf_schedule_copy",
			       base->type.element_size, sizeof(int));
		return -1;
	}
	return lf_schedule_copy(action, offset, &value, 1);
}

trigger_handle_t lf_schedule_token(void *action, interval_t offset, lf_token_t *token)
{
	if (token != NULL) {
		lf_c_token_retain(token);
	}
	return lf_c_schedule(((lf_action_base_t *)action)->info->id, offset, token);
}

trigger_handle_t lf_schedule_value(void *action, interval_t offset, void *elements, int count)
{
	lf_action_base_t *base = (lf_action_base_t *)action;

	if (count < 0) {
		lf_print_error("lf_schedule_value: an array cannot have %d elements", count);
		return -1;
	}
	lf_token_t *token = lf_c_token_for(&base->type, base->info->pool, elements, (size_t)count, LF_VALUE_GIVEN_);
	return lf_c_schedule(base->info->id, offset, token);
}

trigger_handle_t lf_schedule_copy(void *action, interval_t offset, const void *elements, size_t count)
{
	lf_action_base_t *base = (lf_action_base_t *)action;

	if (elements == NULL) {
		return lf_c_schedule(base->info->id, offset, NULL);
	}
	return lf_c_schedule(base->info->id, offset, lf_c_token_copy(&base->type, base->info->pool, elements, count));
}

/* ---- Which port or action has a type ---- */

bool lf_c_port_has_type(uint16_t port, const token_type_t *type)
{
	return port < lf_port_count && &lf_ports[port]->type == type;
}

bool lf_c_trigger_has_type(uint16_t trigger, const token_type_t *type)
{
	return lf_c_shows_trigger(trigger) && &lf_triggers[trigger]->type == type;
}
