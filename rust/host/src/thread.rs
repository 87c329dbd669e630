// SPDX-License-Identifier: Apache-2.0
//! Threads for physical actions.

use lf_model::{PhysicalLink, ReactionContext};

/// What reactions see of this module; it is in the prelude.
pub trait SpawnPhysicalThread {
    /// Runs `body` on a thread of its own, which can schedule physical actions through the link that it is given.
    ///
    /// A thread that still runs when the program has ended does not hold it up.
    fn spawn_physical_thread<F: FnOnce(PhysicalLink) + Send + 'static>(&mut self, body: F);
}

impl SpawnPhysicalThread for ReactionContext<'_> {
    fn spawn_physical_thread<F: FnOnce(PhysicalLink) + Send + 'static>(&mut self, body: F) {
        let link = self.physical_link();
        std::thread::spawn(move || body(link));
    }
}
