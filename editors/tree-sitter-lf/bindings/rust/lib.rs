// SPDX-License-Identifier: Apache-2.0
//! The tree-sitter grammar of Lingua Franca, as `grammar.js` and `src/scanner.c` make it.
#![cfg(feature = "parser")]

use tree_sitter_language::LanguageFn;

#[expect(unsafe_code, reason = "the generated parser is C")]
mod parser {
    unsafe extern "C" {
        pub(super) fn tree_sitter_lf() -> *const ();
    }
}

/// The language, for `tree_sitter::Parser::set_language`.
#[expect(unsafe_code, reason = "the generated parser is C")]
// SAFETY: the function is the one that the generator makes for this purpose.
pub const LANGUAGE: LanguageFn = unsafe { LanguageFn::from_raw(parser::tree_sitter_lf) };

/// The generated files, by their paths in `src`: what editors compile, beside `scanner.c`.
pub const GENERATED: [(&str, &str); 4] = [
    ("parser.c", include_str!(concat!(env!("OUT_DIR"), "/parser.c"))),
    ("tree_sitter/alloc.h", include_str!(concat!(env!("OUT_DIR"), "/tree_sitter/alloc.h"))),
    ("tree_sitter/array.h", include_str!(concat!(env!("OUT_DIR"), "/tree_sitter/array.h"))),
    ("tree_sitter/parser.h", include_str!(concat!(env!("OUT_DIR"), "/tree_sitter/parser.h"))),
];
