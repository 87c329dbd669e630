/* SPDX-License-Identifier: Apache-2.0 */
/* Which federation to join, and where its RTI is: from Kconfig, and on native_sim from the command line. */

#include <lf/platform.h>

#ifdef CONFIG_ARCH_POSIX

#include <cmdline.h>
#include <soc.h>

/* The values from the command line; native_sim sets NULL and UINT32_MAX for missing ones. */
static char *given_federation_id;
static char *given_rti_address;
static uint32_t given_rti_port = UINT32_MAX;

static void add_options(void)
{
	static struct args_struct_t options[] = {
		{
			.option = "lf-federation-id",
			.name = "id",
			.type = 's',
			.dest = (void *)&given_federation_id,
			.descript = "Federation id, instead of CONFIG_LF_FEDERATION_ID",
		},
		{
			.option = "lf-rti-address",
			.name = "address",
			.type = 's',
			.dest = (void *)&given_rti_address,
			.descript = "IP address of the RTI, instead of CONFIG_LF_RTI_ADDRESS",
		},
		{
			.option = "lf-rti-port",
			.name = "port",
			.type = 'u',
			.dest = (void *)&given_rti_port,
			.descript = "TCP port of the RTI, instead of CONFIG_LF_RTI_PORT",
		},
		ARG_TABLE_ENDMARKER,
	};

	native_add_command_line_opts(options);
}

NATIVE_TASK(add_options, PRE_BOOT_1, 10);

#else

static const char *const given_federation_id;
static const char *const given_rti_address;
static const uint32_t given_rti_port = UINT32_MAX;

#endif

const char *lf_federation_id(void)
{
	return given_federation_id != NULL ? given_federation_id : CONFIG_LF_FEDERATION_ID;
}

int lf_rti_address(uint8_t octets[16])
{
	const char *address = given_rti_address != NULL ? given_rti_address : CONFIG_LF_RTI_ADDRESS;

#ifdef CONFIG_NET_IPV6
	if (zsock_inet_pton(AF_INET6, address, octets) == 1) {
		return 16;
	}
#endif
	return zsock_inet_pton(AF_INET, address, octets) == 1 ? 4 : 0;
}

uint32_t lf_rti_port(void)
{
	return given_rti_port != UINT32_MAX ? given_rti_port : CONFIG_LF_RTI_PORT;
}
