// SPDX-License-Identifier: Apache-2.0
//! Static memory that somebody gets, once and for ever. It may be all zero at first, and then takes no flash.

use core::cell::UnsafeCell;
use core::hint;
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

/// A value that goes to whoever asks first.
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

    /// The value, for the first who asks.
    #[expect(clippy::mut_from_ref, reason = "nobody gets it a second time")]
    pub(crate) fn take(&'static self) -> Option<&'static mut T> {
        let is_first = !self.taken.swap(true, Ordering::Acquire);
        // SAFETY: this call alone has found `taken` unset, which is never unset again, and nobody else accesses the
        // cell, which is there for ever.
        is_first.then(|| unsafe { &mut *self.value.get() })
    }
}

/// A place for a value that is made when the program runs.
#[repr(transparent)]
pub(crate) struct Place<T>(MaybeUninit<T>);

// SAFETY: there is no value in a place that can be sent, for what puts one in borrows the place as long as it is there.
unsafe impl<T> Send for Place<T> {}

impl<T> Place<T> {
    pub(crate) const EMPTY: Self = Self(MaybeUninit::uninit());

    /// Puts a value in. It is not inlined, so that what lies on the stack on the way there is gone from it before the
    /// event loop begins.
    #[inline(never)]
    pub(crate) fn fill(&'static mut self, value: impl FnOnce() -> T) -> &'static mut T {
        self.0.write(value())
    }

    /// Room for a value of another type that is not larger, for a static cannot name a type with lifetimes of the
    /// function that makes its value. Who writes a value drops it, if it has to be.
    pub(crate) fn room<U>(&mut self) -> &mut MaybeUninit<U> {
        const { assert!(size_of::<U>() <= size_of::<T>() && align_of::<U>() <= align_of::<T>(), "there is no room") };
        // A compiler that knows the address writes it out in each function, which takes more code than to hand it on.
        // SAFETY: the place is as large as a `U` at least, is aligned for it, and is borrowed as long as the result;
        // and any bytes are a `MaybeUninit`, before and afterwards.
        hint::black_box(unsafe { &mut *(&raw mut self.0).cast() })
    }

    /// Puts a value into each place, as long as there are values, and gives those that have one. Never are all on a
    /// stack.
    pub(crate) fn fill_all(places: &'static mut [Self], values: impl Iterator<Item = T>) -> &'static mut [T] {
        let mut count = 0;
        for (place, value) in places.iter_mut().zip(values) {
            place.0.write(value);
            count += 1;
        }
        // SAFETY: the first so many places have a value, a place is laid out as its value is, and the slice borrows
        // what `places` does.
        unsafe { core::slice::from_raw_parts_mut(places.as_mut_ptr().cast(), count) }
    }
}

/// A value that one caller puts in and another one takes out, who may be on another thread.
pub(crate) struct Handover<T> {
    place: Once<Place<T>>,
    /// The value, as long as it is there.
    full: AtomicPtr<T>,
}

impl<T: Send> Handover<T> {
    pub(crate) const fn new() -> Self {
        Self { place: Once::new(Place::EMPTY), full: AtomicPtr::new(ptr::null_mut()) }
    }

    /// Puts in what `value` makes; `None`, without making it, for all but the first who want to.
    pub(crate) fn put<E>(&'static self, value: impl FnOnce() -> Result<T, E>) -> Option<Result<(), E>> {
        let place = self.place.take()?;
        Some(value().map(|value| self.full.store(place.fill(|| value), Ordering::Release)))
    }

    /// The value, for the first who asks after it was put in.
    #[expect(clippy::mut_from_ref, reason = "nobody gets it a second time")]
    pub(crate) fn take(&'static self) -> Option<&'static mut T> {
        // SAFETY: the pointer is null, or the reference that `put` got for ever and gave up; the swap hands it to one.
        unsafe { self.full.swap(ptr::null_mut(), Ordering::Acquire).as_mut() }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::vec::Vec;

    use super::{Handover, Once, Place};

    #[test]
    fn one_of_many_threads_gets_a_value() {
        static VALUE: Once<u32> = Once::new(7);
        let takers: Vec<_> = (0..8).map(|_| thread::spawn(|| VALUE.take().map(|value| *value))).collect();
        let taken: Vec<_> = takers.into_iter().filter_map(|taker| taker.join().expect("it does not panic")).collect();
        assert_eq!(taken, [7]);
    }

    #[test]
    fn places_are_filled_as_far_as_there_are_values() {
        static PLACES: Once<[Place<u32>; 3]> = Once::new([Place::EMPTY; 3]);
        let [first, rest @ ..] = PLACES.take().expect("nobody has it");
        assert_eq!(first.fill(|| 1), &mut 1);
        let filled = Place::fill_all(rest, [2].into_iter());
        filled[0] += 1;
        assert_eq!(filled, [3]);
    }

    #[test]
    fn a_place_has_room_for_values_that_borrow() {
        static PLACE: Once<Place<(&'static u32, u64)>> = Once::new(Place::EMPTY);
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
