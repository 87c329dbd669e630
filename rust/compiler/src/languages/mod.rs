// SPDX-License-Identifier: Apache-2.0
//! The facts about target languages: types, values, and the semantics of reactions.
//!
//! `resolve` and `analysis` use this table. The facts for the lexer lie below the parser in
//! [`lexical`](crate::lexical), and emission lies above the plan in [`emit`](crate::emit).

pub(crate) mod c;
mod facts;
mod integer;
pub(crate) mod rust;

pub(crate) use facts::{Facts, LiteralKind, Preambles, Unsendable};

use crate::lexical::Language;

impl Language {
    /// Returns the facts about the language.
    pub(crate) fn facts(self) -> &'static Facts {
        match self {
            Self::Rust => &rust::FACTS,
            Self::C => &c::FACTS,
        }
    }
}
