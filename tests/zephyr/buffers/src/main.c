/* SPDX-License-Identifier: Apache-2.0 */

#include <lf/lf.h>
#include <lf/platform.h>

int main(void)
{
	lf_exit(lf_main());
}
