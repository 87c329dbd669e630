/* SPDX-License-Identifier: Apache-2.0 */
/* LF's programs compile this file to have these functions, which are inline here. */
#include <net_util.h>
