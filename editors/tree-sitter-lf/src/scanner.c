// SPDX-License-Identifier: Apache-2.0
/**
 * Tokens of Lingua Franca that no regular expression describes: code of the target language, whose end is the first
 * `=}` outside of its strings and comments, and words whose meaning depends on blanks.
 *
 * The words outside of code are read only where the parser expects them. Code is also read where the parser recovers
 * from an error, so that no text of code is taken for one of LF.
 */

#include <string.h>

#include "tree_sitter/alloc.h"
#include "tree_sitter/parser.h"

/* The order is that of `externals` in grammar.js. */
enum token {
	CODE_OPEN,
	RUST_CODE,
	C_CODE,
	CPP_CODE,
	OTHER_CODE,
	CODE_CLOSE,
	TARGET_NAME,
	UNIT,
	PROPERTY_NAME,
	PATH,
	HOST,
	NOTHING,
	RECOVERY,
};

enum place {
	OUTSIDE,
	BEFORE_CODE,
	BEHIND_CODE,
};

struct scanner {
	/* The token for code; its order is that of the targets. */
	char language;
	char place;
};

/* Longer words are no target and no unit. */
#define WORD_SIZE 8

static bool is_digit(int32_t c)
{
	return c >= '0' && c <= '9';
}

static bool is_word(int32_t c)
{
	return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_blank(int32_t c)
{
	return c == ' ' || c == '\t' || c == '\r' || c == '\f';
}

static bool is_one_of(int32_t c, const char *characters)
{
	return c > 0 && c < 128 && strchr(characters, c) != NULL;
}

static void advance(TSLexer *lexer)
{
	lexer->advance(lexer, false);
}

/* Reads a word, of which the first bytes are kept, and returns its length. */
static size_t read_word(TSLexer *lexer, char word[WORD_SIZE])
{
	size_t length = 0;
	for (; is_word(lexer->lookahead); length++) {
		if (length < WORD_SIZE - 1) {
			word[length] = (char)lexer->lookahead;
		}
		advance(lexer);
	}
	word[length < WORD_SIZE ? length : 0] = '\0';
	return length;
}

/* Code. */

/* A token of code that can hide an end. */
struct hiding {
	/* Whether an `=}` was within it; the first one is marked as the end of the code. */
	bool has_end;
	/* Whether only blanks are before the current character on its line. */
	bool begins_line;
};

/* Reads a character of a token that hides ends. Returns whether an end is here that counts nevertheless: no string and
 * no comment is likely to have it at the beginning of a line, where it is the end of code whose string is not closed.
 */
static bool read_hidden(TSLexer *lexer, struct hiding *hiding)
{
	int32_t c = lexer->lookahead;
	if (c == '=' && (!hiding->has_end || hiding->begins_line)) {
		lexer->mark_end(lexer);
	}
	advance(lexer);
	if (c == '=' && lexer->lookahead == '}') {
		hiding->has_end = true;
		return hiding->begins_line;
	}
	hiding->begins_line = c == '\n' || (hiding->begins_line && is_blank(c));
	return false;
}

/* The next functions read a token, and return whether the end of the code was found in it. */

static bool read_line_comment(TSLexer *lexer, bool continues)
{
	struct hiding hiding = {0};
	while (!lexer->eof(lexer) && lexer->lookahead != '\n') {
		bool is_escape = continues && lexer->lookahead == '\\';
		if (read_hidden(lexer, &hiding)) {
			return true;
		}
		if (is_escape && lexer->lookahead == '\r') {
			advance(lexer);
		}
		if (is_escape && !lexer->eof(lexer)) {
			advance(lexer);
		}
	}
	return hiding.has_end && lexer->eof(lexer);
}

static bool read_block_comment(TSLexer *lexer, bool nests)
{
	struct hiding hiding = {0};
	int32_t last = 0;
	size_t depth = 1;
	while (!lexer->eof(lexer)) {
		int32_t c = lexer->lookahead;
		if (read_hidden(lexer, &hiding)) {
			return true;
		}
		if (last == '*' && c == '/') {
			depth--;
			c = 0;
		} else if (nests && last == '/' && c == '*') {
			depth++;
			c = 0;
		}
		if (depth == 0) {
			return false;
		}
		last = c;
	}
	return hiding.has_end;
}

/* Reads a string behind its opening quote; one of a single line that is not closed there is none. */
static bool read_string(TSLexer *lexer, int32_t quote, bool has_lines)
{
	struct hiding hiding = {0};
	while (!lexer->eof(lexer) && (has_lines || lexer->lookahead != '\n')) {
		int32_t c = lexer->lookahead;
		if (read_hidden(lexer, &hiding)) {
			return true;
		}
		if (c == quote) {
			return false;
		}
		if (c == '\\' && !lexer->eof(lexer)) {
			hiding.begins_line = lexer->lookahead == '\n';
			advance(lexer);
		}
	}
	return hiding.has_end;
}

/* Reads a raw string of Rust behind its opening quote. */
static bool read_raw_string(TSLexer *lexer, size_t hashes)
{
	struct hiding hiding = {0};
	while (!lexer->eof(lexer)) {
		int32_t c = lexer->lookahead;
		if (read_hidden(lexer, &hiding)) {
			return true;
		}
		size_t found = 0;
		while (c == '"' && found < hashes && lexer->lookahead == '#') {
			advance(lexer);
			found++;
		}
		if (c == '"' && found == hashes) {
			return false;
		}
	}
	return hiding.has_end;
}

/* Reads the rest of a word of Rust, and the raw string that it begins, if it does. */
static bool read_rust_word(TSLexer *lexer, int32_t first)
{
	char rest[WORD_SIZE];
	size_t length = read_word(lexer, rest);
	bool begins_raw = first == 'r' ? length == 0 : (first == 'b' || first == 'c') && length == 1 && rest[0] == 'r';
	if (!begins_raw) {
		return false;
	}
	size_t hashes = 0;
	while (lexer->lookahead == '#') {
		advance(lexer);
		hashes++;
	}
	if (lexer->lookahead != '"') {
		return false;
	}
	advance(lexer);
	return read_raw_string(lexer, hashes);
}

/* Reads the rest of a word of C. Numbers can have quotes between their digits. */
static void read_c_word(TSLexer *lexer, int32_t first)
{
	while (is_word(lexer->lookahead) || (is_digit(first) && lexer->lookahead == '\'')) {
		advance(lexer);
	}
}

/* Reads an escaped character of Rust behind its quote and its backslash. */
static void read_escaped(TSLexer *lexer)
{
	if (!lexer->eof(lexer)) {
		advance(lexer);
	}
	while (!lexer->eof(lexer)) {
		int32_t c = lexer->lookahead;
		advance(lexer);
		if (c == '\'' || c == '\n') {
			return;
		}
	}
}

/* Reads one character, and marks the end of code before it if it may begin the end. */
static int32_t read_marked(TSLexer *lexer)
{
	int32_t c = lexer->lookahead;
	if (c == '=') {
		lexer->mark_end(lexer);
	}
	advance(lexer);
	return c;
}

/* Reads code up to its end, or to the end of the text. */
static void read_code(TSLexer *lexer, char language)
{
	bool is_rust = language == RUST_CODE;
	bool is_known = language != OTHER_CODE;
	while (!lexer->eof(lexer)) {
		int32_t c = read_marked(lexer);
		if (is_rust && c == '\'') {
			if (lexer->lookahead == '\\') {
				advance(lexer);
				read_escaped(lexer);
				continue;
			}
			c = read_marked(lexer);
			if (lexer->lookahead == '\'') {
				advance(lexer);
				continue;
			}
			// The quote was that of a lifetime, and what follows it is a token of its own.
		}
		bool is_end = c == '=' && lexer->lookahead == '}';
		if (!is_known) {
			// Nothing hides an end.
		} else if (c == '/' && lexer->lookahead == '/') {
			is_end = read_line_comment(lexer, !is_rust);
		} else if (c == '/' && lexer->lookahead == '*') {
			advance(lexer);
			is_end = read_block_comment(lexer, is_rust);
		} else if (c == '"' || c == '\'') {
			is_end = read_string(lexer, c, is_rust);
		} else if (is_word(c) && is_rust) {
			is_end = read_rust_word(lexer, c);
		} else if (is_word(c)) {
			read_c_word(lexer, c);
		}
		if (is_end) {
			return;
		}
	}
	lexer->mark_end(lexer);
}

/* Reads a part of a code block behind its `{=`: the code, or the `=}`. */
static bool scan_code(struct scanner *scanner, TSLexer *lexer)
{
	if (lexer->eof(lexer)) {
		return false;
	}
	lexer->mark_end(lexer);
	if (lexer->lookahead == '=') {
		advance(lexer);
		if (lexer->lookahead == '}') {
			advance(lexer);
			lexer->mark_end(lexer);
			scanner->place = OUTSIDE;
			lexer->result_symbol = CODE_CLOSE;
			return true;
		}
	}
	if (scanner->place == BEHIND_CODE) {
		return false;
	}
	read_code(lexer, scanner->language);
	scanner->place = BEHIND_CODE;
	lexer->result_symbol = (TSSymbol)scanner->language;
	return true;
}

/* Words outside of code. */

static bool is_same(const char *word, const char *lower_case)
{
	size_t at = 0;
	for (; word[at] != '\0'; at++) {
		char c = word[at] >= 'A' && word[at] <= 'Z' ? (char)(word[at] - 'A' + 'a') : word[at];
		if (c != lower_case[at]) {
			return false;
		}
	}
	return lower_case[at] == '\0';
}

/* Reads the name behind `target`, which chooses the language of all later code. */
static bool scan_target_name(struct scanner *scanner, TSLexer *lexer)
{
	char word[WORD_SIZE];
	if (is_digit(lexer->lookahead) || read_word(lexer, word) == 0) {
		return false;
	}
	if (is_same(word, "rust")) {
		scanner->language = RUST_CODE;
	} else if (is_same(word, "c") || is_same(word, "uc")) {
		scanner->language = C_CODE;
	} else if (is_same(word, "ccpp") || is_same(word, "cpp")) {
		scanner->language = CPP_CODE;
	} else {
		scanner->language = OTHER_CODE;
	}
	lexer->result_symbol = TARGET_NAME;
	return true;
}

static const char *const UNITS[] = {
	"ns", "nsec", "nsecs", "us",     "usec",    "usecs", "ms",   "msec",   "msecs",
	"s",  "sec",  "secs",  "second", "seconds", "min",   "mins", "minute", "minutes",
	"h",  "hour", "hours", "d",      "day",     "days",  "wk",   "week",   "weeks",
};

/* Reads a unit of time. An unknown word that ends a value is one that is misspelt. */
static bool scan_unit(TSLexer *lexer)
{
	char word[WORD_SIZE];
	if (is_digit(lexer->lookahead) || read_word(lexer, word) == 0) {
		return false;
	}
	lexer->mark_end(lexer);
	lexer->result_symbol = UNIT;
	for (size_t unit = 0; unit < sizeof(UNITS) / sizeof(UNITS[0]); unit++) {
		if (strcmp(word, UNITS[unit]) == 0) {
			return true;
		}
	}
	while (is_blank(lexer->lookahead)) {
		advance(lexer);
	}
	return lexer->eof(lexer) || is_one_of(lexer->lookahead, ",;)]}\n");
}

/* Reads words that are joined by `-`. */
static bool scan_property_name(TSLexer *lexer)
{
	if (is_digit(lexer->lookahead) || !is_word(lexer->lookahead)) {
		return false;
	}
	do {
		while (is_word(lexer->lookahead)) {
			advance(lexer);
		}
		lexer->mark_end(lexer);
		if (lexer->lookahead == '-') {
			advance(lexer);
		}
	} while (is_word(lexer->lookahead) && !is_digit(lexer->lookahead));
	lexer->result_symbol = PROPERTY_NAME;
	return true;
}

/* Returns whether a word is a value of its own, and not the name of a file. */
static bool is_value(const char *word)
{
	static const char *const VALUES[] = {"true", "True", "false", "False", "forever", "never"};
	for (size_t value = 0; value < sizeof(VALUES) / sizeof(VALUES[0]); value++) {
		if (strcmp(word, VALUES[value]) == 0) {
			return true;
		}
	}
	return false;
}

/* Reads a word or a path without quotes. */
static bool scan_path(TSLexer *lexer)
{
	char word[WORD_SIZE];
	// A path does not begin with a digit or with a dot before one: these are numbers.
	int32_t first = lexer->lookahead;
	if (is_digit(first) || first == '-') {
		return false;
	}
	bool found = read_word(lexer, word) > 0;
	if (found && is_value(word)) {
		return false;
	}
	lexer->mark_end(lexer);
	while (is_word(lexer->lookahead) || is_one_of(lexer->lookahead, "./\\-")) {
		int32_t c = lexer->lookahead;
		advance(lexer);
		bool begins_comment = c == '/' && is_one_of(lexer->lookahead, "/*");
		if (begins_comment || (!found && first == '.' && is_digit(lexer->lookahead))) {
			break;
		}
		found = true;
		lexer->mark_end(lexer);
	}
	lexer->result_symbol = PATH;
	return found;
}

static bool scan_host(TSLexer *lexer)
{
	bool found = false;
	while (is_word(lexer->lookahead) || is_one_of(lexer->lookahead, ".:-@[]%")) {
		found = true;
		advance(lexer);
	}
	lexer->result_symbol = HOST;
	return found;
}

void *tree_sitter_lf_external_scanner_create(void)
{
	struct scanner *scanner = ts_calloc(1, sizeof(struct scanner));
	scanner->language = RUST_CODE;
	return scanner;
}

void tree_sitter_lf_external_scanner_destroy(void *payload)
{
	ts_free(payload);
}

unsigned tree_sitter_lf_external_scanner_serialize(void *payload, char *buffer)
{
	const struct scanner *scanner = payload;
	buffer[0] = scanner->language;
	buffer[1] = scanner->place;
	return 2;
}

void tree_sitter_lf_external_scanner_deserialize(void *payload, const char *buffer, unsigned length)
{
	struct scanner *scanner = payload;
	scanner->language = RUST_CODE;
	scanner->place = OUTSIDE;
	if (length == 2) {
		scanner->language = buffer[0];
		scanner->place = buffer[1];
	}
}

bool tree_sitter_lf_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid)
{
	struct scanner *scanner = payload;
	if (scanner->place != OUTSIDE) {
		return scan_code(scanner, lexer);
	}
	bool has_line = false;
	while (is_blank(lexer->lookahead) || lexer->lookahead == '\n') {
		has_line |= lexer->lookahead == '\n';
		lexer->advance(lexer, true);
	}
	if (lexer->lookahead == '{') {
		advance(lexer);
		if (lexer->lookahead != '=') {
			return false;
		}
		advance(lexer);
		scanner->place = BEFORE_CODE;
		lexer->result_symbol = CODE_OPEN;
		lexer->mark_end(lexer);
		return true;
	}
	if (valid[RECOVERY]) {
		return false;
	}
	if (valid[TARGET_NAME]) {
		return scan_target_name(scanner, lexer);
	}
	if (valid[UNIT]) {
		return !has_line && scan_unit(lexer);
	}
	if (valid[PROPERTY_NAME]) {
		return scan_property_name(lexer);
	}
	if (valid[PATH]) {
		return scan_path(lexer);
	}
	return valid[HOST] && scan_host(lexer);
}
