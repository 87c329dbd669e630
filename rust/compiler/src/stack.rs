// SPDX-License-Identifier: Apache-2.0
//! Stack for recursive code.

use std::panic::resume_unwind;
use std::thread::{Builder, ScopedJoinHandle, scope};

/// The stack size in bytes of threads that parse. The parser of Rust takes up to 40 KiB for a level of code without
/// optimization, and code can have 256 of them. The system allocates the memory as the stack is used.
pub(crate) const STACK_BYTES: usize = 64 << 20;

/// Runs a closure with [`STACK_BYTES`] of stack; on the current stack if no thread can be created.
pub(crate) fn with_stack<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let mut work = Some(work);
    let result = scope(|scope| {
        let run = || work.take().map(|work| work());
        Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run).ok().and_then(joined)
    });
    match (result, work) {
        (Some(result), _) => result,
        (None, Some(work)) => work(),
        (None, None) => unreachable!("what was run has a result, or its panic has gone on"),
    }
}

/// Returns the result of a thread.
pub(crate) fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}
