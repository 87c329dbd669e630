/* SPDX-License-Identifier: Apache-2.0 */
/* Devices that are not there, for native_sim and for tests: what programs do to them, and what they find there. */

#ifndef LF_EMULATION_H_
#define LF_EMULATION_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct device;

/*
 * Reads the last setting of a channel of a PWM of the kind lf,emulated-pwm, in nanoseconds, initially 0. Returns 0, or
 * -EINVAL when it has no such channel.
 */
int lf_emulated_pwm_get(const struct device *pwm, uint32_t channel, uint32_t *period, uint32_t *pulse);

/*
 * Sets, or reads, bytes of a device of the kind lf,emulated-registers, from the beginning of a register on; what is
 * transferred meanwhile is wholly older or wholly newer. Callable from interrupts. Returns 0, or -EINVAL when they are
 * more than it has.
 */
int lf_emulated_registers_set(const struct device *device, uint8_t first, const uint8_t *bytes, size_t length);
int lf_emulated_registers_get(const struct device *device, uint8_t first, uint8_t *bytes, size_t length);

/*
 * Sets the value of a channel of enum sensor_channel of a sensor of the kind lf,emulated-sensor, in millionths
 * of its unit; a sample is ready. Callable from interrupts. Returns 0, or -EINVAL when there is no such channel.
 */
int lf_emulated_sensor_set(const struct device *device, int channel, int64_t micro);

#ifdef __cplusplus
}
#endif

#endif
