// SPDX-License-Identifier: Apache-2.0
//! The plan of a program that uses every feature.

use std::collections::BTreeMap;

use crate::compile;
use crate::plan::Plan;

/// The program.
pub(super) const TEXT: &str = include_str!("everything.lf");

/// Its path.
pub(super) const PATH: &str = "src/Everything.lf";

/// Returns its plan.
pub(super) fn plan() -> Plan {
    let sources = BTreeMap::from([(PATH.to_owned(), TEXT.to_owned())]);
    let compilation = compile(PATH, &sources);
    let said = compilation.diagnostics.render(crate::Style::Plain);
    compilation.plan.unwrap_or_else(|| panic!("it has a plan:\n{said}"))
}

/// Returns the line and column of the first occurrence of a text in the program.
pub(super) fn place_of(text: &str) -> (usize, usize) {
    let start = TEXT.find(text).unwrap_or_else(|| panic!("{text:?} is not in the program"));
    let line = TEXT[..start].matches('\n').count() + 1;
    let column = TEXT[..start].rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    (line, column)
}
