/* SPDX-License-Identifier: Apache-2.0 */
/* A set of pointers, except for NULL and (void *)1. */
#ifndef LF_HASHSET_H_
#define LF_HASHSET_H_

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * A table whose size is a power of two; an item is in the first free place from that of its hash on. Bodies go through
 * `items`, in which NULL and (void *)1 are no items.
 */
struct hashset_st {
	void **items;
	size_t capacity;
	size_t nitems;
	/* The items, and the places of those that were removed. */
	size_t taken;
};
typedef struct hashset_st *hashset_t;

#define LF_HASHSET_REMOVED_ ((void *)1)

/* Returns a set with room for 2 to this power, or NULL without memory. */
static inline hashset_t hashset_create(unsigned short nbits)
{
	hashset_t set = (hashset_t)calloc(1, sizeof(*set));

	if (set == NULL) {
		return NULL;
	}
	set->capacity = (size_t)1 << (nbits < 1 ? 1 : nbits);
	set->items = (void **)calloc(set->capacity, sizeof(*set->items));
	if (set->items == NULL) {
		free(set);
		return NULL;
	}
	return set;
}

static inline void hashset_destroy(hashset_t set)
{
	if (set != NULL) {
		free(set->items);
		free(set);
	}
}

static inline size_t hashset_num_items(hashset_t set)
{
	return set->nitems;
}

/* Returns the place of an item, or the free one where the search for it ends. A table always has one. */
static inline size_t lf_hashset_place_(hashset_t set, void *item)
{
	/* The upper bits of the product depend on all bits of the address. */
	uint64_t hash = (uint64_t)(uintptr_t)item * 0x9E3779B97F4A7C15u;
	size_t place = (size_t)(hash >> 32) & (set->capacity - 1);

	while (set->items[place] != NULL && set->items[place] != item) {
		place = (place + 1) & (set->capacity - 1);
	}
	return place;
}

static inline int hashset_is_member(hashset_t set, void *item)
{
	return item != NULL && item != LF_HASHSET_REMOVED_ && set->items[lf_hashset_place_(set, item)] == item;
}

/* Returns 1 for a new item, 0 for one that is in the set, and -1 for one that cannot be, or without memory. */
static inline int hashset_add(hashset_t set, void *item)
{
	if (item == NULL || item == LF_HASHSET_REMOVED_) {
		return -1;
	}
	if (hashset_is_member(set, item)) {
		return 0;
	}
	/* A table that is nearly full is slow. */
	if ((set->taken + 1) * 4 > set->capacity * 3) {
		struct hashset_st larger = {NULL, set->capacity * 2, set->nitems, set->nitems};

		larger.items = (void **)calloc(larger.capacity, sizeof(*larger.items));
		if (larger.items == NULL) {
			return -1;
		}
		for (size_t i = 0; i < set->capacity; i++) {
			if (set->items[i] != NULL && set->items[i] != LF_HASHSET_REMOVED_) {
				larger.items[lf_hashset_place_(&larger, set->items[i])] = set->items[i];
			}
		}
		free(set->items);
		*set = larger;
	}
	set->items[lf_hashset_place_(set, item)] = item;
	set->nitems++;
	set->taken++;
	return 1;
}

/* Returns 1 if the item was in the set, else 0. */
static inline int hashset_remove(hashset_t set, void *item)
{
	if (!hashset_is_member(set, item)) {
		return 0;
	}
	set->items[lf_hashset_place_(set, item)] = LF_HASHSET_REMOVED_;
	set->nitems--;
	return 1;
}

#ifdef __cplusplus
}
#endif

#endif /* LF_HASHSET_H_ */
