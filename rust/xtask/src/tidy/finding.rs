// SPDX-License-Identifier: Apache-2.0
//! The findings of rules.

/// One thing that is not tidy.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Finding {
    /// The file, relative to the repository, with `:LINE` where there is one.
    pub(super) place: String,
    /// The problem, and its solution.
    pub(super) what: String,
}
