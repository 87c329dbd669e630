/* SPDX-License-Identifier: Apache-2.0 */
#include "deque.h"

#include <lf.h>

typedef struct deque_node_t {
	struct deque_node_t *before;
	struct deque_node_t *behind;
	void *value;
} deque_node_t;

void deque_initialize(deque_t *d)
{
	*d = (deque_t){0};
}

bool deque_is_empty(deque_t *d)
{
	return d->size == 0;
}

size_t deque_size(deque_t *d)
{
	return d->size;
}

static deque_node_t *node(deque_t *d, void *value)
{
	deque_node_t *made = calloc(1, sizeof(*made));

	if (made == NULL) {
		lf_print_error_and_exit("a deque has no memory for an element");
	}
	made->value = value;
	d->size++;
	return made;
}

void deque_push_front(deque_t *d, void *value)
{
	deque_node_t *first = node(d, value);

	first->behind = d->front;
	*(d->front == NULL ? &d->back : &d->front->before) = first;
	d->front = first;
}

void deque_push_back(deque_t *d, void *value)
{
	deque_node_t *last = node(d, value);

	last->before = d->back;
	*(d->back == NULL ? &d->front : &d->back->behind) = last;
	d->back = last;
}

/* Takes an element out of the queue, and returns its value. */
static void *take(deque_t *d, deque_node_t *taken)
{
	void *value;

	if (taken == NULL) {
		return NULL;
	}
	*(taken->before == NULL ? &d->front : &taken->before->behind) = taken->behind;
	*(taken->behind == NULL ? &d->back : &taken->behind->before) = taken->before;
	d->size--;
	value = taken->value;
	free(taken);
	return value;
}

void *deque_pop_front(deque_t *d)
{
	return take(d, d->front);
}

void *deque_pop_back(deque_t *d)
{
	return take(d, d->back);
}

void *deque_peek_front(deque_t *d)
{
	return d->front == NULL ? NULL : d->front->value;
}

void *deque_peek_back(deque_t *d)
{
	return d->back == NULL ? NULL : d->back->value;
}
