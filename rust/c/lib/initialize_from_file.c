/* SPDX-License-Identifier: Apache-2.0 */
#include "initialize_from_file.h"

#include <ctype.h>
#include <lf.h>

/* Returns a row without its end, which the caller frees, or NULL. */
static char *row(const char *filename, size_t number)
{
	FILE *file = fopen(filename, "r");
	char *line = NULL;
	size_t room = 0;
	ssize_t length = -1;

	if (file == NULL) {
		lf_print_error("%s: %s", filename, strerror(errno));
		return NULL;
	}
	for (size_t at = 0; at <= number; at++) {
		length = getline(&line, &room, file);
		if (length < 0) {
			lf_print_error("%s has no row %zu: it ends after %zu", filename, number, at);
			free(line);
			line = NULL;
			break;
		}
	}
	(void)fclose(file);
	while (line != NULL && length > 0 && (line[length - 1] == '\n' || line[length - 1] == '\r')) {
		line[--length] = '\0';
	}
	return line;
}

/* Writes a text to the variable; returns whether it is a value of the variable's type. */
typedef bool (*reader_t)(char *text, void *variable);

static bool read_double(char *text, void *variable)
{
	char *end;
	double value = strtod(text, &end);

	*(double *)variable = value;
	return end != text && *end == '\0';
}

static bool read_int(char *text, void *variable)
{
	char *end;
	long value;

	errno = 0;
	value = strtol(text, &end, 0);
	*(int *)variable = (int)value;
	return end != text && *end == '\0' && errno == 0 && value >= INT_MIN && value <= INT_MAX;
}

static bool read_string(char *text, void *variable)
{
	char *copy = strdup(text);

	*(char **)variable = copy;
	return copy != NULL;
}

/* Returns a text without blanks at its ends. */
static char *trimmed(char *text)
{
	size_t length;

	while (isspace((unsigned char)*text)) {
		text++;
	}
	length = strlen(text);
	while (length > 0 && isspace((unsigned char)text[length - 1])) {
		text[--length] = '\0';
	}
	return text;
}

/*
 * Cuts the next value off a row, which is NULL behind the last one. A value in quotes may contain delimiters, and is
 * returned without the quotes; two quotes in it are one.
 */
static char *next_value(char **rest, char delimiter)
{
	char *text = *rest, *end, *to;

	while (isspace((unsigned char)*text)) {
		text++;
	}
	if (*text == '"') {
		for (end = to = text + 1; *end != '\0' && (*end != '"' || *++end == '"'); end++) {
			*to++ = *end;
		}
		*rest = strchr(end, delimiter);
		*to = '\0';
		text++;
	} else {
		*rest = strchr(text, delimiter);
		if (*rest != NULL) {
			**rest = '\0';
		}
		text = trimmed(text);
	}
	*rest = *rest == NULL ? NULL : *rest + 1;
	return text;
}

static int read_row(const char *filename, char delimiter, size_t number, va_list variables, reader_t read)
{
	char *line = row(filename, number);
	char *rest = line;
	int count = 0;

	if (line == NULL) {
		return -1;
	}
	for (void *variable; rest != NULL && (variable = va_arg(variables, void *)) != NULL; count++) {
		char *text = next_value(&rest, delimiter);

		if (!read(text, variable)) {
			lf_print_error("%s: row %zu: `%s` is no value for variable %d", filename, number, text, count);
			count = -1;
			break;
		}
	}
	free(line);
	return count;
}

#define LF_READ_ROW_(type, reader)                                                                                     \
	int lf_initialize_##type(const char *filename, char delimiter, size_t row_number, ...)                         \
	{                                                                                                              \
		va_list variables;                                                                                     \
		int count;                                                                                             \
                                                                                                                       \
		va_start(variables, row_number);                                                                       \
		count = read_row(filename, delimiter, row_number, variables, reader);                                  \
		va_end(variables);                                                                                     \
		return count;                                                                                          \
	}

LF_READ_ROW_(double, read_double)
LF_READ_ROW_(int, read_int)
LF_READ_ROW_(string, read_string)
