/* SPDX-License-Identifier: Apache-2.0 */
/* Tokens: values that ports, actions and queues share, and that are freed with their last share. */

#include "lf_internal.h"

static lf_token_t *take_from(lf_pool_t *pool)
{
	lf_token_t *token = NULL;

	LF_CRITICAL_SECTION_ENTER();
	if (pool->free != NULL) {
		token = pool->free;
		pool->free = token->next;
	} else if (pool->touched < pool->count) {
		token = (lf_token_t *)(void *)&pool->blocks[pool->touched * pool->block_size];
		pool->touched++;
	}
	LF_CRITICAL_SECTION_EXIT();
	return token;
}

lf_token_t *lf_c_pool_take(lf_pool_t *pool, size_t bytes)
{
	/* On Linux pools are empty. */
	if (pool == NULL || pool->block_size < LF_TOKEN_SIZE_ + bytes) {
		return NULL;
	}
	lf_token_t *token = take_from(pool);
	if (token != NULL) {
		*token = (lf_token_t){.pool = pool};
	}
	return token;
}

static lf_token_t *take(token_type_t *type, lf_pool_t *pool, size_t length, size_t bytes)
{
	lf_token_t *token = lf_c_pool_take(pool, bytes);

	if (token == NULL) {
		token = lf_c_store_take(bytes);
	}
	if (token == NULL) {
		const char *name = "";
		size_t name_length = lf_c_name(type, &name);
		lf_print_error_and_exit("there is no memory left for a value of %zu bytes of %.*s: %s", bytes,
					(int)name_length, name, lf_c_store_advice());
	}
	token->type = type;
	token->length = length;
	token->ref_count = 1;
	token->next = NULL;
	token->arrival = NEVER;
	return token;
}

lf_token_t *lf_c_token_with_room(token_type_t *type, lf_pool_t *pool, size_t length, size_t bytes)
{
	lf_token_t *token = take(type, pool, length, bytes);

	token->value = (unsigned char *)token + LF_TOKEN_SIZE_;
	token->place = LF_VALUE_INSIDE_;
	return token;
}

lf_token_t *lf_c_token_for(token_type_t *type, lf_pool_t *pool, void *value, size_t length, uint8_t place)
{
	lf_token_t *token = take(type, pool, length, 0);

	token->value = value;
	token->place = place;
	return token;
}

lf_token_t *lf_c_token_copy(token_type_t *type, lf_pool_t *pool, const void *value, size_t length)
{
	size_t bytes = type->element_size * length;
	/* A destructor may free what it is given, which then has to be freeable by itself. */
	void *own = type->destructor != NULL ? lf_c_allocate(bytes) : NULL;

	lf_token_t *token = own != NULL ? lf_c_token_for(type, pool, own, length, LF_VALUE_GIVEN_)
					: lf_c_token_with_room(type, pool, length, bytes);
	if (bytes > 0) {
		memcpy(token->value, value, bytes);
	}
	return token;
}

void lf_c_token_retain(lf_token_t *token)
{
	(void)lf_c_count(&token->ref_count, 1);
}

size_t lf_c_token_encode(const lf_token_t *token, unsigned char *bytes, size_t room)
{
	size_t size = token->value != NULL ? token->type->element_size * token->length : 0;

	if (size > 0 && size <= room) {
		memcpy(bytes, token->value, size);
	}
	return size;
}

void lf_c_token_release(lf_token_t *token)
{
	if (lf_c_count(&token->ref_count, -1) > 0) {
		return;
	}
	if (token->place == LF_VALUE_GIVEN_ && token->value != NULL) {
		if (token->type->destructor != NULL) {
			token->type->destructor(token->value);
		} else {
			lf_c_free(token->value);
		}
	}
	lf_pool_t *pool = token->pool;
	if (pool == NULL) {
		lf_c_store_give(token);
		return;
	}
	LF_CRITICAL_SECTION_ENTER();
	token->next = pool->free;
	pool->free = token;
	LF_CRITICAL_SECTION_EXIT();
}

lf_token_t *lf_new_token(void *port_or_action, void *elements, size_t count)
{
	/* A type is the beginning of each port and action. */
	token_type_t *type = (token_type_t *)port_or_action;

	lf_token_t *token = lf_c_token_for(type, NULL, elements, count, LF_VALUE_GIVEN_);
	token->ref_count = 0;
	return token;
}

/* ---- Copies that a reaction makes for itself ---- */

/* Those of the reaction that this thread runs; on boards one thread runs all of them. */
#ifdef __ZEPHYR__
static lf_token_t *copies;
#else
static __thread lf_token_t *copies;
#endif

lf_token_t *lf_c_writable_copy(lf_port_base_t *port)
{
	lf_token_t *token = port->token;
	lf_token_t *copy;

	if (token == NULL || (port->info->readers == 1 && token->ref_count == 1)) {
		return token;
	}
	/* The port may be a body's own copy, which does not live as long as the token may. */
	token_type_t *type = &lf_ports[port->info->id]->type;
	if (type->copy_constructor != NULL) {
		void *value = type->copy_constructor(token->value);
		copy = lf_c_token_for(type, port->info->pool, value, token->length, LF_VALUE_GIVEN_);
	} else {
		copy = lf_c_token_copy(type, port->info->pool, token->value, token->length);
	}
	copy->next = copies;
	copies = copy;
	return copy;
}

void lf_c_run(void (*body)(uint16_t), uint16_t reaction, void *running)
{
	lf_c_set_running(running);
	body(reaction);
	lf_c_set_running(NULL);
	while (copies != NULL) {
		lf_token_t *copy = copies;
		copies = copy->next;
		lf_c_token_release(copy);
	}
}
