// SPDX-License-Identifier: Apache-2.0
//! Threads for physical actions, on static stacks.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use lf_model::{ModelError, PhysicalLink, ReactionContext};

use crate::kconfig::{LF_USER_THREAD_CLOSURE_SIZE, LF_USER_THREADS};
use crate::raw;

/// What reactions see of this module; it is in the prelude.
pub trait SpawnPhysicalThread {
    /// Runs `body` on a thread of its own, which can schedule physical actions through the link that it is given.
    ///
    /// Where `CONFIG_LF_USER_THREADS` threads are running already, the program ends with an error after this reaction.
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F);
}

impl SpawnPhysicalThread for ReactionContext<'_> {
    fn spawn_physical_thread<F: FnOnce(&mut PhysicalLink) + Send + 'static>(&mut self, body: F) {
        let mut link = self.physical_link();
        if let Err(error) = spawn(move || body(&mut link)) {
            self.fail(error);
        }
    }
}

/// Room for a closure, aligned like the largest of Rust's usual types.
type Room = MaybeUninit<[u64; LF_USER_THREAD_CLOSURE_SIZE.div_ceil(8)]>;

/// A thread that is running, or could be.
struct ThreadPlace {
    taken: AtomicBool,
    /// How to run what is in the room; set before the thread starts.
    run: UnsafeCell<Option<unsafe fn(*mut Room)>>,
    closure: UnsafeCell<Room>,
}

// SAFETY: the cells are accessed only by the thread that has set `taken` to true, and by the thread that it starts
// then, which sets `taken` to false after its last access.
unsafe impl Sync for ThreadPlace {}

static PLACES: [ThreadPlace; LF_USER_THREADS] = [const {
    ThreadPlace {
        taken: AtomicBool::new(false),
        run: UnsafeCell::new(None),
        closure: UnsafeCell::new(MaybeUninit::uninit()),
    }
}; LF_USER_THREADS];

/// Starts a thread. A closure that captures more than `CONFIG_LF_USER_THREAD_CLOSURE_SIZE` bytes does not compile.
///
/// # Errors
/// [`ModelError::NoThreadLeft`] when `CONFIG_LF_USER_THREADS` of them are running.
pub fn spawn<F: FnOnce() + Send + 'static>(body: F) -> Result<(), ModelError> {
    const {
        assert!(size_of::<F>() <= size_of::<Room>(), "the closure captures too much: see LF_USER_THREAD_CLOSURE_SIZE");
        assert!(align_of::<F>() <= align_of::<Room>(), "the closure captures something of unusual alignment");
    }
    let take = |place: &ThreadPlace| !place.taken.swap(true, Ordering::Acquire);
    let free = PLACES.iter().enumerate().find(|(_, place)| take(place));
    let (index, place) = free.ok_or(ModelError::NoThreadLeft { threads: LF_USER_THREADS })?;
    // SAFETY: this thread has just taken the place, so nobody else accesses the cells; the closure fits, as asserted.
    unsafe {
        place.closure.get().cast::<F>().write(body);
        *place.run.get() = Some(run::<F>);
    }
    // SAFETY: the place was not taken, so its thread is not running, or is past its last access.
    unsafe { raw::lf_thread_start(index, Some(enter)) };
    Ok(())
}

/// Where each thread begins.
extern "C" fn enter(index: usize) {
    let place = &PLACES[index];
    // SAFETY: the place was taken for this thread, and filled before it was started.
    unsafe {
        if let Some(run) = (*place.run.get()).take() {
            run(place.closure.get());
        }
    }
    place.taken.store(false, Ordering::Release);
}

/// Runs the closure in a place.
///
/// # Safety
/// The room holds a valid `F`, which nobody uses afterwards.
unsafe fn run<F: FnOnce()>(room: *mut Room) {
    // SAFETY: as promised by the caller.
    let body = unsafe { room.cast::<F>().read() };
    body();
}
