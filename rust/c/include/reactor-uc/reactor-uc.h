/* SPDX-License-Identifier: Apache-2.0 */
/* A name by which programs of micro LF include the API. */
#include <lf.h>
