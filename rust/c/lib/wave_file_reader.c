/* SPDX-License-Identifier: Apache-2.0 */
#include "wave_file_reader.h"

#include <lf.h>

/* The longest file that is read, in bytes. */
#define BYTES_MAX (1L << 30)

#define PCM 1

static uint32_t little_endian(const unsigned char *bytes, int count)
{
	uint32_t value = 0;

	for (int i = count - 1; i >= 0; i--) {
		value = value << 8 | bytes[i];
	}
	return value;
}

/* Reads a whole file. */
static unsigned char *read_file(const char *path, long *size)
{
	FILE *file = fopen(path, "rb");
	unsigned char *bytes = NULL;

	if (file == NULL) {
		lf_print_error("%s: %s", path, strerror(errno));
		return NULL;
	}
	if (fseek(file, 0, SEEK_END) == 0 && (*size = ftell(file)) > 0 && *size <= BYTES_MAX &&
	    fseek(file, 0, SEEK_SET) == 0) {
		bytes = malloc((size_t)*size);
	}
	if (bytes == NULL || fread(bytes, 1, (size_t)*size, file) != (size_t)*size) {
		lf_print_error("%s cannot be read", path);
		free(bytes);
		bytes = NULL;
	}
	(void)fclose(file);
	return bytes;
}

/* Finds the chunk of a name; returns its content and its length, or NULL. */
static const unsigned char *chunk(const unsigned char *bytes, long size, const char *name, uint32_t *length)
{
	long at = 12;

	while (at + 8 <= size) {
		*length = little_endian(bytes + at + 4, 4);
		if (*length > (unsigned long)(size - at - 8)) {
			return NULL;
		}
		if (memcmp(bytes + at, name, 4) == 0) {
			return bytes + at + 8;
		}
		/* Chunks begin at even places. */
		at += 8 + (long)*length + (long)(*length % 2);
	}
	return NULL;
}

lf_waveform_t *read_wave_file(const char *path)
{
	long size = 0;
	unsigned char *bytes = read_file(path, &size);
	const unsigned char *format, *samples;
	uint32_t format_length, length;
	lf_waveform_t *made = NULL;

	if (bytes == NULL) {
		return NULL;
	}
	if (size < 12 || memcmp(bytes, "RIFF", 4) != 0 || memcmp(bytes + 8, "WAVE", 4) != 0) {
		lf_print_error("%s is no WAV file", path);
		goto done;
	}
	format = chunk(bytes, size, "fmt ", &format_length);
	samples = chunk(bytes, size, "data", &length);
	if (format == NULL || format_length < 16 || samples == NULL) {
		lf_print_error("%s is cut off", path);
		goto done;
	}
	if (little_endian(format, 2) != PCM || little_endian(format + 14, 2) != 16) {
		lf_print_error("%s has another format than 16-bit PCM", path);
		goto done;
	}
	made = calloc(1, sizeof(*made));
	if (made != NULL) {
		made->length = length / 2;
		made->num_channels = (uint16_t)little_endian(format + 2, 2);
		made->waveform = calloc(made->length + 1, sizeof(int16_t));
	}
	if (made == NULL || made->waveform == NULL) {
		lf_print_error("there is no memory for %s", path);
		free(made);
		made = NULL;
		goto done;
	}
	for (uint32_t i = 0; i < made->length; i++) {
		made->waveform[i] = (int16_t)little_endian(samples + 2 * (size_t)i, 2);
	}
done:
	free(bytes);
	return made;
}
