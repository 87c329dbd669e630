// SPDX-License-Identifier: Apache-2.0
//! Names that C reserves.

/// C's keywords, including those of C23 that older compilers know as macros.
const KEYWORDS: &[&str] = &[
    "_Accum",
    "_Alignas",
    "_Alignof",
    "_Atomic",
    "_BitInt",
    "_Bool",
    "_Complex",
    "_Decimal128",
    "_Decimal32",
    "_Decimal64",
    "_Float128",
    "_Float16",
    "_Float32",
    "_Float64",
    "_Fract",
    "_Generic",
    "_Imaginary",
    "_Noreturn",
    "_Pragma",
    "_Sat",
    "_Static_assert",
    "_Thread_local",
    "alignas",
    "alignof",
    "asm",
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

/// Keywords of C++ that are none of C.
const WORDS_OF_CPP: &[&str] = &[
    "and",
    "and_eq",
    "asm",
    "bitand",
    "bitor",
    "catch",
    "char8_t",
    "char16_t",
    "char32_t",
    "class",
    "co_await",
    "co_return",
    "co_yield",
    "compl",
    "concept",
    "const_cast",
    "consteval",
    "constinit",
    "decltype",
    "delete",
    "dynamic_cast",
    "explicit",
    "export",
    "friend",
    "mutable",
    "namespace",
    "new",
    "noexcept",
    "not",
    "not_eq",
    "operator",
    "or",
    "or_eq",
    "private",
    "protected",
    "public",
    "reinterpret_cast",
    "requires",
    "static_cast",
    "template",
    "this",
    "throw",
    "try",
    "typeid",
    "typename",
    "using",
    "virtual",
    "wchar_t",
    "xor",
    "xor_eq",
];

/// Returns the reason why no name in C, or no variable of a body, can be this one.
pub(in crate::lexical) fn problem(name: &str, in_bodies: bool, is_cpp: bool) -> Option<&'static str> {
    if in_bodies && name == "self" {
        return Some("reaction bodies have a variable of this name");
    }
    if in_bodies && name.starts_with("lf_") {
        return Some("names that begin so are those of the functions that bodies call");
    }
    if !in_bodies && name == "base" {
        return Some("`self->base` is what the runtime knows of a reactor");
    }
    // Macros are in capitals; other names with one underscore are seldom C's.
    let is_macro =
        |rest: &str| rest.starts_with(|c: char| c.is_uppercase()) && !rest.contains(|c: char| c.is_lowercase());
    if name.starts_with("__") || name.strip_prefix('_').is_some_and(is_macro) {
        return Some("names that begin so are C's own");
    }
    if is_cpp && WORDS_OF_CPP.contains(&name) {
        return Some("it is a word of C++");
    }
    KEYWORDS.contains(&name).then_some("it is a word of C")
}
