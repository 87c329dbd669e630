// SPDX-License-Identifier: Apache-2.0
//! Static memory that is handed out exactly once. It may be all zero at first, and then takes no flash.

use core::cell::UnsafeCell;
use core::hint;
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

/// A value that the first caller gets.
pub(crate) struct Once<T> {
    taken: AtomicBool,
    value: UnsafeCell<T>,
}

// SAFETY: only one call of `take` gives access to the value, perhaps on another thread than made it, which `Send`
// allows.
unsafe impl<T: Send> Sync for Once<T> {}

impl<T> Once<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self { taken: AtomicBool::new(false), value: UnsafeCell::new(value) }
    }

    /// Returns the value to the first caller, and `None` to all others.
    #[expect(clippy::mut_from_ref, reason = "nobody gets it a second time")]
    pub(crate) fn take(&'static self) -> Option<&'static mut T> {
        let is_first = !self.taken.swap(true, Ordering::Acquire);
        // SAFETY: this call alone has found `taken` unset, which is never unset again, so there is no other access to
        // the cell, which lives forever.
        is_first.then(|| unsafe { &mut *self.value.get() })
    }
}

/// A slot for a value that is made when the program runs.
#[repr(transparent)]
pub(crate) struct StaticSlot<T>(MaybeUninit<T>);

// SAFETY: a slot never contains a value that could be sent with it, because the code that puts one in borrows the slot
// for the value's lifetime.
unsafe impl<T> Send for StaticSlot<T> {}

impl<T> StaticSlot<T> {
    pub(crate) const EMPTY: Self = Self(MaybeUninit::uninit());

    /// Puts a value in. It is not inlined, so that its own stack frame is gone before the event loop begins.
    #[inline(never)]
    pub(crate) fn fill(&'static mut self, value: impl FnOnce() -> T) -> &'static mut T {
        self.0.write(value())
    }

    /// Returns room for a value of another type that is not larger, because a static cannot name a type with the
    /// lifetimes of the function that makes its value. A value that is written there is not dropped.
    pub(crate) fn room<U>(&mut self) -> &mut MaybeUninit<U> {
        const { assert!(size_of::<U>() <= size_of::<T>() && align_of::<U>() <= align_of::<T>(), "there is no room") };
        // A compiler that knows the address writes it out in each function, which takes more code than passing it.
        // SAFETY: the slot is at least as large as a `U`, is aligned for it, and is borrowed for the lifetime of the
        // result; and any bytes are a `MaybeUninit`, before and afterwards.
        hint::black_box(unsafe { &mut *(&raw mut self.0).cast() })
    }

    /// Puts a value into each slot, while there are values, and returns the filled ones. The values are never on a
    /// stack all at once.
    pub(crate) fn fill_all(slots: &'static mut [Self], values: impl Iterator<Item = T>) -> &'static mut [T] {
        let mut count = 0;
        for (place, value) in slots.iter_mut().zip(values) {
            place.0.write(value);
            count += 1;
        }
        // SAFETY: the first slots, as many as were counted, have a value, a slot has the layout of its value, and the
        // slice borrows what `slots` does.
        unsafe { core::slice::from_raw_parts_mut(slots.as_mut_ptr().cast(), count) }
    }
}

/// A value that one caller puts in and another one takes out, perhaps on another thread.
pub(crate) struct Handover<T> {
    place: Once<StaticSlot<T>>,
    /// The value, while it is there.
    full: AtomicPtr<T>,
}

impl<T: Send> Handover<T> {
    pub(crate) const fn new() -> Self {
        Self { place: Once::new(StaticSlot::EMPTY), full: AtomicPtr::new(ptr::null_mut()) }
    }

    /// Puts in the value of `value`; returns `None`, without making it, for all but the first caller.
    pub(crate) fn put<E>(&'static self, value: impl FnOnce() -> Result<T, E>) -> Option<Result<(), E>> {
        let place = self.place.take()?;
        Some(value().map(|value| self.full.store(place.fill(|| value), Ordering::Release)))
    }

    /// Returns the value to the first caller after it was put in.
    #[expect(clippy::mut_from_ref, reason = "nobody gets it a second time")]
    pub(crate) fn take(&'static self) -> Option<&'static mut T> {
        // SAFETY: the pointer is null, or the `'static` reference that `put` got and gave up; the swap passes it to one
        // caller.
        unsafe { self.full.swap(ptr::null_mut(), Ordering::Acquire).as_mut() }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::vec::Vec;

    use super::{Handover, Once, StaticSlot};

    #[test]
    fn one_of_many_threads_gets_a_value() {
        static VALUE: Once<u32> = Once::new(7);
        let takers: Vec<_> = (0..8).map(|_| thread::spawn(|| VALUE.take().map(|value| *value))).collect();
        let taken: Vec<_> = takers.into_iter().filter_map(|taker| taker.join().expect("it does not panic")).collect();
        assert_eq!(taken, [7]);
    }

    #[test]
    fn places_are_filled_as_far_as_there_are_values() {
        static PLACES: Once<[StaticSlot<u32>; 3]> = Once::new([StaticSlot::EMPTY; 3]);
        let [first, rest @ ..] = PLACES.take().expect("nobody has it");
        assert_eq!(first.fill(|| 1), &mut 1);
        let filled = StaticSlot::fill_all(rest, [2].into_iter());
        filled[0] += 1;
        assert_eq!(filled, [3]);
    }

    #[test]
    fn a_place_has_room_for_values_that_borrow() {
        static PLACE: Once<StaticSlot<(&'static u32, u64)>> = Once::new(StaticSlot::EMPTY);
        let place = PLACE.take().expect("nobody has it");
        for number in [1, 2] {
            let value: &mut (&u32, u32) = place.room().write((&number, 5));
            assert_eq!(value, &mut (&number, 5));
        }
    }

    #[test]
    fn a_value_is_handed_over_once_and_only_if_it_could_be_made() {
        static HANDOVER: Handover<u32> = Handover::new();
        static FAILED: Handover<u32> = Handover::new();
        assert_eq!(HANDOVER.take(), None);
        assert_eq!(HANDOVER.put(|| Ok::<_, ()>(5)), Some(Ok(())));
        assert_eq!(HANDOVER.put(|| -> Result<_, ()> { unreachable!("it has a value") }), None);
        let taken = thread::spawn(|| HANDOVER.take().map(|value| *value)).join().expect("it does not panic");
        assert_eq!((taken, HANDOVER.take()), (Some(5), None));
        assert_eq!(FAILED.put(|| Err("no port")), Some(Err("no port")));
        assert_eq!(FAILED.take(), None);
    }
}
