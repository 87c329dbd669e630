/* SPDX-License-Identifier: Apache-2.0 */
/* Which federation to join, and where its RTI is: from Kconfig, and on native_sim from the command line. */

#include <lf/platform.h>

#ifdef CONFIG_ARCH_POSIX

#include <cmdline.h>
#include <soc.h>

static char *federation_id = CONFIG_LF_FEDERATION_ID;
static char *rti_address = CONFIG_LF_RTI_ADDRESS;
static uint32_t rti_port = CONFIG_LF_RTI_PORT;

static void add_options(void)
{
	static struct args_struct_t options[] = {
		{
			.option = "lf-federation-id",
			.name = "id",
			.type = 's',
			.dest = (void *)&federation_id,
			.descript = "Federation id, instead of CONFIG_LF_FEDERATION_ID",
		},
		{
			.option = "lf-rti-address",
			.name = "address",
			.type = 's',
			.dest = (void *)&rti_address,
			.descript = "IPv4 address of the RTI, instead of CONFIG_LF_RTI_ADDRESS",
		},
		{
			.option = "lf-rti-port",
			.name = "port",
			.type = 'u',
			.dest = (void *)&rti_port,
			.descript = "TCP port of the RTI, instead of CONFIG_LF_RTI_PORT",
		},
		ARG_TABLE_ENDMARKER,
	};

	native_add_command_line_opts(options);
}

NATIVE_TASK(add_options, PRE_BOOT_1, 10);

#else

static const char *const federation_id = CONFIG_LF_FEDERATION_ID;
static const char *const rti_address = CONFIG_LF_RTI_ADDRESS;
static const uint32_t rti_port = CONFIG_LF_RTI_PORT;

#endif

const char *lf_federation_id(void)
{
	return federation_id;
}

const char *lf_rti_address(void)
{
	return rti_address;
}

uint32_t lf_rti_port(void)
{
	return rti_port;
}
