/* SPDX-License-Identifier: Apache-2.0 */
#include "../include/FunctionsInC/Changer.h"
#include "include/FunctionsInC/Inside.h"
#include "FunctionsInC/Keeper_pair.h"
#include "../../include/FunctionsInC/Numbers.h"
#include "../../../include/FunctionsInC/Numbers.h"

void number(numbers_self_t *self, numbers_one_t *one, numbers_several_t **several)
{
	lf_set(one, self->first);
	for (int i = 0; i < 2; i++) {
		lf_set(several[i], self->first + i + 1);
	}
}

void collect(inside_self_t *self, numbers_one_t **ones, numbers_several_t ***all, numbers_one_t *one,
	     numbers_several_t **several, keeper_pair_x_t *x)
{
	int sum = 0;

	for (int i = 0; i < 2; i++) {
		sum += ones[i]->value + all[i][0]->value + all[i][1]->value;
	}
	lf_print("%s has %d, %d, %d and %d", lf_reactor_name(self), sum, one->value, several[0]->value,
		 several[1]->value);
	lf_set(x, ((pair){sum, several[1]->value / 2.0}));
}

void keep(keeper_pair_self_t *self, keeper_pair_x_t *x, keeper_pair_y_t *y)
{
	self->last = x->value;
	lf_set(y, self->last);
}

void change(changer_self_t *self, changer_x_t *x)
{
	(void)self;
	x->value.small++;
	lf_print("changed to %d and %d", x->value.small, (int)x->value.large);
}
