/* SPDX-License-Identifier: Apache-2.0 */
/* What the bodies note, line by line. */
#include "program.h"

static char notes[4096];
static size_t length;

void note(const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	length += (size_t)vsnprintf(&notes[length], sizeof(notes) - length, format, arguments);
	va_end(arguments);
	length += (size_t)snprintf(&notes[length], sizeof(notes) - length, "\n");
	LF_TEST(length < sizeof(notes), "too many notes");
}

const char *take_notes(void)
{
	return notes;
}
