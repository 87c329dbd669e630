/* SPDX-License-Identifier: Apache-2.0 */
#define FIRST 1

int measure(int first);

/* The program has it. */
int next_value(int value);
