// SPDX-License-Identifier: Apache-2.0
//! Threads for physical actions.

use std::thread;

use lf_model::{ModelError, PhysicalLink, ReactionContext};

/// What reactions see of this module; it is in the prelude.
pub trait SpawnPhysicalThread {
    /// Runs `body` on a thread of its own, which can schedule physical actions through the link that it is given.
    ///
    /// A thread that still runs when the program has ended does not hold it up. Where the operating system starts no
    /// further thread, the program ends with an error after this reaction.
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F);
}

impl SpawnPhysicalThread for ReactionContext<'_> {
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F) {
        let mut link = self.physical_link();
        if let Err(error) = thread::Builder::new().spawn(move || body(&mut link)) {
            self.fail(ModelError::ThreadRefused { os_error: error.raw_os_error().unwrap_or(0) });
        }
    }
}
