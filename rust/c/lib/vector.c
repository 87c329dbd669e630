/* SPDX-License-Identifier: Apache-2.0 */
#include "vector.h"

#include <lf.h>

/* The number of calls of vector_vote() that a vector needs before it shrinks. */
#define VOTES 100

static size_t capacity(vector_t *v)
{
	return (size_t)(v->end - v->start);
}

static void resize(vector_t *v, size_t places)
{
	size_t size = vector_size(v);
	void **start = realloc(v->start, places * sizeof(*start));

	if (start == NULL) {
		lf_print_error_and_exit("a vector has no memory for %zu elements", places);
	}
	*v = (vector_t){
		.start = start,
		.next = start + size,
		.end = start + places,
		.votes_required = VOTES,
	};
}

/* Makes room for this number of elements. */
static void reserve(vector_t *v, size_t size)
{
	size_t places = capacity(v) == 0 ? 1 : capacity(v);

	while (places < size) {
		places *= 2;
	}
	if (places > capacity(v)) {
		resize(v, places);
	}
}

vector_t vector_new(size_t initial_capacity)
{
	vector_t v = {.votes_required = VOTES};

	reserve(&v, initial_capacity);
	return v;
}

void vector_free(vector_t *v)
{
	free(v->start);
	*v = (vector_t){0};
}

void vector_push(vector_t *v, void *element)
{
	reserve(v, vector_size(v) + 1);
	*v->next++ = element;
}

void vector_pushall(vector_t *v, void **array, size_t size)
{
	reserve(v, vector_size(v) + size);
	for (size_t i = 0; i < size; i++) {
		*v->next++ = array[i];
	}
}

void *vector_pop(vector_t *v)
{
	return v->next == v->start ? NULL : *--v->next;
}

void **vector_at(vector_t *v, size_t index)
{
	reserve(v, index + 1);
	while (vector_size(v) <= index) {
		*v->next++ = NULL;
	}
	return v->start + index;
}

size_t vector_size(vector_t *v)
{
	return (size_t)(v->next - v->start);
}

void vector_vote(vector_t *v)
{
	if (vector_size(v) >= capacity(v) / 4) {
		v->votes = 0;
	} else if (++v->votes >= v->votes_required) {
		resize(v, capacity(v) / 2);
	}
}
