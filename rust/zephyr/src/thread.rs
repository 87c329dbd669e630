// SPDX-License-Identifier: Apache-2.0
//! Threads for physical actions, on static stacks.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use lf_model::{ModelError, PhysicalLink, ReactionContext};

use crate::kconfig::{LF_USER_THREAD_CLOSURE_SIZE, LF_USER_THREADS};
use crate::raw;

/// The interface of this module for reactions; it is in the prelude.
pub trait SpawnPhysicalThread {
    /// Runs `body` on a thread of its own, which can schedule physical actions through its argument.
    ///
    /// If `CONFIG_LF_USER_THREADS` threads are running already, the program ends with an error after this reaction.
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

/// A slot for a running thread.
struct ThreadSlot {
    taken: AtomicBool,
    /// The function that runs the closure in the room; set before the thread starts.
    run: UnsafeCell<Option<unsafe fn(*mut Room)>>,
    closure: UnsafeCell<Room>,
}

// SAFETY: the cells are accessed only by the thread that has set `taken` to true, and by the thread that it starts
// then, which sets `taken` to false after its last access.
unsafe impl Sync for ThreadSlot {}

static SLOTS: [ThreadSlot; LF_USER_THREADS] = [const {
    ThreadSlot {
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
    let take = |slot: &ThreadSlot| !slot.taken.swap(true, Ordering::Acquire);
    let free = SLOTS.iter().enumerate().find(|(_, slot)| take(slot));
    let (index, slot) = free.ok_or(ModelError::NoThreadLeft { threads: LF_USER_THREADS })?;
    // SAFETY: this thread has just taken the slot, so no other thread accesses the cells; the closure fits, as
    // asserted.
    unsafe {
        slot.closure.get().cast::<F>().write(body);
        *slot.run.get() = Some(run::<F>);
    }
    // SAFETY: the slot was not taken, so its thread is not running, or is past its last access.
    unsafe { raw::lf_thread_start(index, Some(enter)) };
    Ok(())
}

/// Runs a thread from its beginning.
extern "C" fn enter(index: usize) {
    let slot = &SLOTS[index];
    // SAFETY: the slot was taken for this thread, and filled before it was started.
    unsafe {
        if let Some(run) = (*slot.run.get()).take() {
            run(slot.closure.get());
        }
    }
    slot.taken.store(false, Ordering::Release);
}

/// Runs the closure in a slot.
///
/// # Safety
/// The room holds a valid `F`, which is not used afterwards.
unsafe fn run<F: FnOnce()>(room: *mut Room) {
    // SAFETY: as promised by the caller.
    let body = unsafe { room.cast::<F>().read() };
    body();
}
