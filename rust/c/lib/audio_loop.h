/* SPDX-License-Identifier: Apache-2.0 */
/* Sound on the loudspeakers: waveforms that begin at times, mixed. */
#ifndef LF_AUDIO_LOOP_H_
#define LF_AUDIO_LOOP_H_

#include <lf_time.h>

#include "wave_file_reader.h"

/* In samples per second. */
#ifndef SAMPLE_RATE
#define SAMPLE_RATE 44100
#endif
/* The samples that are written at once, and how long they last. */
#ifndef AUDIO_BUFFER_SIZE
#define AUDIO_BUFFER_SIZE 4410
#endif
#ifndef BUFFER_DURATION_NS
#define BUFFER_DURATION_NS 100000000LL
#endif
#ifndef NUM_CHANNELS
#define NUM_CHANNELS 1
#endif
#ifndef MAX_AMPLITUDE
#define MAX_AMPLITUDE 32765
#endif
/* The maximum number of waveforms at one time. */
#ifndef NUM_NOTES
#define NUM_NOTES 8
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Begins to write sound, of which the first sample belongs to this time. Without a device, a line says so. */
void lf_start_audio_loop(instant_t start_time);
void lf_stop_audio_loop(void);

/*
 * Plays a waveform, louder or softer by a factor, as one more note. What should have begun before what is being written
 * begins at once. Returns 0, or 1 if it is late. The waveform has to live until it has been played; NULL is silence.
 */
int lf_play_audio_waveform(lf_waveform_t *waveform, float emphasis, instant_t start_time);

#ifdef __cplusplus
}
#endif

#endif /* LF_AUDIO_LOOP_H_ */
