/* SPDX-License-Identifier: Apache-2.0 */
#include "audio_loop.h"

#include <alsa/asoundlib.h>
#include <pthread.h>

#undef LF_MICRO
#include <lf.h>

/* A waveform that is being played, or will be. */
typedef struct {
	lf_waveform_t *waveform;
	float emphasis;
	/* The next sample to play, less than 0 before the note begins. */
	int64_t at;
} note_t;

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_t writer;
static bool is_running;
static snd_pcm_t *device;
/* The time of the first sample that is not written yet. */
static instant_t written_until;
static note_t notes[NUM_NOTES];
static int next_note;

static int16_t limited(double value)
{
	double limit = MAX_AMPLITUDE;

	return (int16_t)(value > limit ? limit : value < -limit ? -limit : value);
}

/* Adds what all notes have next to a buffer. */
static void mix(int16_t *buffer)
{
	for (int i = 0; i < AUDIO_BUFFER_SIZE * NUM_CHANNELS; i++) {
		double sum = 0.0;

		for (note_t *note = notes; note < notes + NUM_NOTES; note++) {
			if (note->waveform == NULL) {
				continue;
			}
			if (note->at >= 0) {
				sum += note->emphasis * note->waveform->waveform[note->at];
			}
			if (++note->at >= (int64_t)note->waveform->length) {
				note->waveform = NULL;
			}
		}
		buffer[i] = limited(sum);
	}
}

static void *write_sound(void *unused)
{
	static int16_t buffer[AUDIO_BUFFER_SIZE * NUM_CHANNELS];

	(void)unused;
	for (;;) {
		bool goes_on;

		pthread_mutex_lock(&mutex);
		goes_on = is_running;
		mix(buffer);
		written_until += BUFFER_DURATION_NS;
		pthread_mutex_unlock(&mutex);
		if (!goes_on) {
			return NULL;
		}
		if (snd_pcm_writei(device, buffer, AUDIO_BUFFER_SIZE) < 0) {
			(void)snd_pcm_prepare(device);
		}
	}
}

void lf_start_audio_loop(instant_t start_time)
{
	int error = 0;

	pthread_mutex_lock(&mutex);
	if (!is_running) {
		error = snd_pcm_open(&device, "default", SND_PCM_STREAM_PLAYBACK, 0);
		if (error == 0) {
			error = snd_pcm_set_params(device, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED,
						   NUM_CHANNELS, SAMPLE_RATE, 1, BUFFER_DURATION_NS / 1000 * 2);
		}
		written_until = start_time;
		is_running = error == 0 && pthread_create(&writer, NULL, write_sound, NULL) == 0;
	}
	pthread_mutex_unlock(&mutex);
	if (error != 0) {
		lf_print_error("there is no sound: %s", snd_strerror(error));
	}
}

void lf_stop_audio_loop(void)
{
	bool was_running;

	pthread_mutex_lock(&mutex);
	was_running = is_running;
	is_running = false;
	pthread_mutex_unlock(&mutex);
	if (was_running) {
		(void)pthread_join(writer, NULL);
		(void)snd_pcm_close(device);
	}
}

int lf_play_audio_waveform(lf_waveform_t *waveform, float emphasis, instant_t start_time)
{
	interval_t until;
	int is_late;

	if (waveform == NULL) {
		return 0;
	}
	pthread_mutex_lock(&mutex);
	until = start_time - written_until;
	is_late = until < 0;
	/* The oldest note makes room. */
	notes[next_note] = (note_t){
		.waveform = waveform,
		.emphasis = emphasis,
		.at = is_late ? 0 : -(until / 1000 * SAMPLE_RATE / 1000000) * NUM_CHANNELS,
	};
	next_note = (next_note + 1) % NUM_NOTES;
	pthread_mutex_unlock(&mutex);
	return is_late;
}
