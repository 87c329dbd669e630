/* SPDX-License-Identifier: Apache-2.0 */
#include "program.h"
char lf_size_0[sizeof(point_t)];
