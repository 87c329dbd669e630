// SPDX-License-Identifier: Apache-2.0
//! How one turn of an event loop ends.

use lf_coordination::Deadline;

/// How one turn of an event loop ends.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Turn<T> {
    /// All that can be done now is done; the loop is to wait until something happens, or this time comes.
    Wait(Deadline),
    /// The loop has come to its end.
    Ended(T),
}
