/* SPDX-License-Identifier: Apache-2.0 */
/* An array of pointers that grows, and shrinks when it has been too large for a while. */
#ifndef LF_VECTOR_H_
#define LF_VECTOR_H_

#include <stddef.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vector_t {
	void **start;
	void **next; /* behind the last element */
	void **end;  /* behind the last place */
	int votes_required;
	int votes;
} vector_t;

vector_t vector_new(size_t initial_capacity);
void vector_free(vector_t *v);
void vector_push(vector_t *v, void *element);
void vector_pushall(vector_t *v, void **array, size_t size);
/* Returns NULL if there is no element. */
void *vector_pop(vector_t *v);
/* Returns the place of an element, which the vector has from then on: those before it that are new are NULL. */
void **vector_at(vector_t *v, size_t index);
size_t vector_size(vector_t *v);
/* Halves the places when the vector has used less than a quarter of them at many calls. */
void vector_vote(vector_t *v);

#ifdef __cplusplus
}
#endif

#endif /* LF_VECTOR_H_ */
