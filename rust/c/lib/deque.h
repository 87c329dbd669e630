/* SPDX-License-Identifier: Apache-2.0 */
/* A queue of pointers with two ends. An empty one is all zeros, or what deque_initialize() has set. */
#ifndef LF_DEQUE_H_
#define LF_DEQUE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct deque_t {
	struct deque_node_t *front;
	struct deque_node_t *back;
	size_t size;
} deque_t;

void deque_initialize(deque_t *d);
bool deque_is_empty(deque_t *d);
size_t deque_size(deque_t *d);
void deque_push_front(deque_t *d, void *value);
void deque_push_back(deque_t *d, void *value);
/* These return NULL if the queue is empty. */
void *deque_pop_front(deque_t *d);
void *deque_pop_back(deque_t *d);
void *deque_peek_front(deque_t *d);
void *deque_peek_back(deque_t *d);

#ifdef __cplusplus
}
#endif

#endif /* LF_DEQUE_H_ */
