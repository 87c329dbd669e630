// SPDX-License-Identifier: Apache-2.0
//! The facts about target languages: types, values, and what reactions do there.
//!
//! `resolve` and `analysis` ask this table. What the lexer has to know lies below the parser in
//! [`lexical`](crate::lexical), and what is emitted lies above the plan in [`emit`](crate::emit).

pub(crate) mod c;
mod facts;
mod integer;
pub(crate) mod rust;

pub(crate) use facts::{Facts, LiteralKind, Preambles, Unsendable};

use crate::lexical::Language;

impl Language {
    /// Returns what is known of the language.
    pub(crate) fn facts(self) -> &'static Facts {
        match self {
            Self::Rust => &rust::FACTS,
            Self::C => &c::FACTS,
        }
    }
}
