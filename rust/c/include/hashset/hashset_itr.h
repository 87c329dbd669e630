/* SPDX-License-Identifier: Apache-2.0 */
/* A walk over the items of a set, which must not change meanwhile; free() ends it. */
#ifndef LF_HASHSET_ITR_H_
#define LF_HASHSET_ITR_H_

#include "hashset.h"

#ifdef __cplusplus
extern "C" {
#endif

struct hashset_itr_st {
	hashset_t set;
	/* The place of the present item, SIZE_MAX before the first one. */
	size_t place;
};
typedef struct hashset_itr_st *hashset_itr_t;

/* Returns the walk before its first item, or NULL without memory. */
static inline hashset_itr_t hashset_iterator(hashset_t set)
{
	hashset_itr_t itr = (hashset_itr_t)calloc(1, sizeof(*itr));

	if (itr != NULL) {
		itr->set = set;
		itr->place = SIZE_MAX;
	}
	return itr;
}

/* Returns the place of the next item, or the number of places. */
static inline size_t lf_hashset_next_(hashset_itr_t itr)
{
	size_t place = itr->place + 1;

	while (place < itr->set->capacity &&
	       (itr->set->items[place] == NULL || itr->set->items[place] == LF_HASHSET_REMOVED_)) {
		place++;
	}
	return place;
}

static inline int hashset_iterator_has_next(hashset_itr_t itr)
{
	return lf_hashset_next_(itr) < itr->set->capacity;
}

/* Goes to the next item; returns its place, or -1 if there is none. */
static inline int hashset_iterator_next(hashset_itr_t itr)
{
	size_t place = lf_hashset_next_(itr);

	if (place >= itr->set->capacity) {
		return -1;
	}
	itr->place = place;
	return (int)place;
}

static inline void *hashset_iterator_value(hashset_itr_t itr)
{
	return itr->place < itr->set->capacity ? itr->set->items[itr->place] : NULL;
}

#ifdef __cplusplus
}
#endif

#endif /* LF_HASHSET_ITR_H_ */
