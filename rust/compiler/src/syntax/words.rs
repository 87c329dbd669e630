// SPDX-License-Identifier: Apache-2.0
//! The keywords of the language.

/// Words that LF does not allow as names.
pub(crate) const RESERVED: &[&str] = &[
    "target",
    "import",
    "main",
    "realtime",
    "reactor",
    "state",
    "mutable",
    "input",
    "output",
    "timer",
    "action",
    "reaction",
    "startup",
    "shutdown",
    "after",
    "deadline",
    "mutation",
    "preamble",
    "new",
    "federated",
    "at",
    "as",
    "from",
    "const",
    "method",
    "interleaved",
    "mode",
    "initial",
    "reset",
    "history",
    "watchdog",
    "extends",
    "forever",
    "never",
    "tardy",
    "logical",
    "physical",
    "private",
    "public",
    "serializer",
    "STP",
    "STAA",
    "true",
    "True",
    "false",
    "False",
    "time",
];

/// Returns whether LF reserves this word.
pub(crate) fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word)
}

/// Words that begin a declaration in the body of a reactor.
pub(super) const MEMBER_STARTS: &[&str] = &[
    "state", "mutable", "input", "output", "timer", "action", "reaction", "mutation", "preamble", "const", "method",
    "mode", "initial", "watchdog", "logical", "physical", "private", "public", "reset",
];

/// Words that begin items of the target languages, and nothing of LF.
pub(super) const CODE_STARTS: &[&str] = &[
    "bool", "char", "double", "enum", "extern", "float", "fn", "impl", "int", "let", "long", "mod", "pub", "short",
    "static", "struct", "trait", "type", "typedef", "union", "unsafe", "unsigned", "use", "void",
];

/// Words that begin a declaration at the top of a file, except for those that may also stand within a reactor.
pub(super) const FILE_STARTS: &[&str] = &["target", "import", "main", "federated", "realtime", "reactor"];
