/* SPDX-License-Identifier: Apache-2.0 */
/* A name by which programs in C include the API. */
#include <lf.h>
