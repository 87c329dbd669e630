// SPDX-License-Identifier: Apache-2.0
//! Names that C keeps for itself.

/// C's words, those of C23 that older compilers know as macros included.
const KEYWORDS: &[&str] = &[
    "alignas",
    "alignof",
    "auto",
    "bool",
    "break",
    "case",
    "char",
    "const",
    "constexpr",
    "continue",
    "default",
    "do",
    "double",
    "else",
    "enum",
    "extern",
    "false",
    "float",
    "for",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "nullptr",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "static_assert",
    "struct",
    "switch",
    "thread_local",
    "true",
    "typedef",
    "typeof",
    "union",
    "unsigned",
    "void",
    "volatile",
    "while",
];

/// Macros that stand for something wherever they are written.
const MACROS: &[&str] = &[
    "BILLION",
    "EOF",
    "FOREVER",
    "FOREVER_MICROSTEP",
    "FOREVER_TAG",
    "LF_FILE_SEPARATOR",
    "LF_PACKAGE_DIRECTORY",
    "LF_SOURCE_DIRECTORY",
    "LF_SOURCE_GEN_DIRECTORY",
    "MILLION",
    "NEVER",
    "NEVER_MICROSTEP",
    "NEVER_TAG",
    "NULL",
    "PRINTF_MICROSTEP",
    "PRINTF_TAG",
    "PRINTF_TIME",
    "ZERO_TAG",
    "errno",
    "stderr",
    "stdin",
    "stdout",
];

/// Why nothing in C can be called so, or no variable of a body.
pub(super) fn problem(name: &str, in_bodies: bool) -> Option<&'static str> {
    if in_bodies && name == "self" {
        return Some("reaction bodies have a variable of this name");
    }
    if in_bodies && name.starts_with("lf_") {
        return Some("names that begin so are those of the functions that bodies call");
    }
    if !in_bodies && name == "base" {
        return Some("`self->base` is what the runtime knows of a reactor");
    }
    if MACROS.contains(&name) {
        return Some("it is a macro of C");
    }
    KEYWORDS.contains(&name).then_some("it is a word of C")
}
