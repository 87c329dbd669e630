/* SPDX-License-Identifier: Apache-2.0 */
/* The keys of an image with encrypted connections; those of the test are in crate/src/lib.rs. */
#define LF_KEY_OWN        {1}
#define LF_KEY_RTI        {9}
#define LF_KEY_FEDERATION {2}
