// SPDX-License-Identifier: Apache-2.0
//! Threads for physical actions.

use std::thread::{self, JoinHandle};

use lf_model::{PhysicalLink, ReactionContext};

/// The interface of this module for reactions; it is in the prelude.
pub trait SpawnPhysicalThread {
    /// Runs `body` on a thread of its own, which can schedule physical actions through its argument. Join the thread to
    /// get the result of `body`.
    ///
    /// A thread that still runs when the program has ended does not hold it up.
    ///
    /// # Panics
    /// If the operating system starts no further thread.
    fn spawn_physical_thread<T, F>(&mut self, body: F) -> JoinHandle<T>
    where
        T: Send + 'static,
        F: FnOnce(&mut PhysicalLink) -> T + Send + 'static;
}

impl SpawnPhysicalThread for ReactionContext<'_> {
    #[track_caller]
    fn spawn_physical_thread<T, F>(&mut self, body: F) -> JoinHandle<T>
    where
        T: Send + 'static,
        F: FnOnce(&mut PhysicalLink) -> T + Send + 'static,
    {
        let mut link = self.physical_link();
        thread::Builder::new().spawn(move || body(&mut link)).unwrap_or_else(|error| {
            panic!(
                "spawn_physical_thread got no thread from the operating system ({error}): let fewer threads run at \
                 once, or raise the limit on their number"
            )
        })
    }
}
