// SPDX-License-Identifier: Apache-2.0
//! What a rule finds.

/// One thing that is not tidy.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Finding {
    /// The file, relative to the repository, with `:LINE` where there is one.
    pub(super) place: String,
    /// What is wrong, and what to do.
    pub(super) what: String,
}
