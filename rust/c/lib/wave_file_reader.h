/* SPDX-License-Identifier: Apache-2.0 */
/* Sound from a WAV file. */
#ifndef LF_WAVE_FILE_READER_H_
#define LF_WAVE_FILE_READER_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lf_waveform_t {
	uint32_t length; /* in samples, of all channels together */
	uint16_t num_channels;
	int16_t *waveform;
} lf_waveform_t;

/*
 * Reads a file of 16-bit PCM samples. Returns NULL, and says why on the console, if that cannot be done; otherwise the
 * caller frees the result, and the samples before it.
 */
lf_waveform_t *read_wave_file(const char *path);

#ifdef __cplusplus
}
#endif

#endif /* LF_WAVE_FILE_READER_H_ */
