// SPDX-License-Identifier: Apache-2.0
//! The end of one turn of an event loop.

use lf_coordination::Deadline;

/// The end of one turn of an event loop.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Turn<T> {
    /// Everything that can be done now is done. Wait until something happens, or until this time.
    Wait(Deadline),
    /// The loop has come to its end.
    Ended(T),
}
