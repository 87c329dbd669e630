/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The keys of the image, from the header that CONFIG_LF_SECURITY_KEYS names. It is generated, is not among the sources,
 * and defines each of these as the initializer of an array of 32 bytes:
 *
 *   LF_KEY_OWN         the secret key of the federate, if there is one in the image
 *   LF_KEY_RTI_OWN     the secret key of the RTI, if it is in the image
 *   LF_KEY_FEDERATION  the secret of the federation
 *   LF_KEY_RTI         the public key of the RTI
 *
 * and LF_KEYS_OF_FEDERATES as the initializer of an array of struct lf_member, if there are any.
 */

#include <lf/platform.h>

#include <zephyr/sys/util.h>

#include CONFIG_LF_SECURITY_KEYS

#if !defined(LF_KEY_FEDERATION) || !defined(LF_KEY_RTI)
#error "The header that CONFIG_LF_SECURITY_KEYS names has no LF_KEY_FEDERATION and LF_KEY_RTI"
#endif
#if defined(CONFIG_LF_FEDERATE) && !defined(LF_KEY_OWN)
#error "The header that CONFIG_LF_SECURITY_KEYS names has no LF_KEY_OWN"
#endif
#if defined(CONFIG_LF_RTI) && !defined(LF_KEY_RTI_OWN)
#error "The header that CONFIG_LF_SECURITY_KEYS names has no LF_KEY_RTI_OWN"
#endif

#ifdef LF_KEYS_OF_FEDERATES
static const struct lf_member federates[] = LF_KEYS_OF_FEDERATES;
#endif

static const struct lf_keys keys = {
#ifdef LF_KEY_OWN
	.own = LF_KEY_OWN,
#endif
#ifdef LF_KEY_RTI_OWN
	.rti_own = LF_KEY_RTI_OWN,
#endif
	.federation = LF_KEY_FEDERATION,
	.rti = LF_KEY_RTI,
#ifdef LF_KEYS_OF_FEDERATES
	.federates = federates,
	.federates_count = ARRAY_SIZE(federates),
#else
	/* A slice of Rust begins somewhere, even if nothing is in it. */
	.federates = (const struct lf_member *)&keys,
#endif
};

const struct lf_keys *lf_keys(void)
{
	return &keys;
}
