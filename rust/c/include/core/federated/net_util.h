/* SPDX-License-Identifier: Apache-2.0 */
/* A name by which programs in C include it. */
#include <net_util.h>
