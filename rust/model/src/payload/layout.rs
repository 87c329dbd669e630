// SPDX-License-Identifier: Apache-2.0
//! The layout of the fields of a struct, a tuple or an enum, which is that of C.
//!
//! | type | C |
//! |---|---|
//! | struct, tuple | `struct { … }` of its fields, in their order |
//! | enum | `struct { int number; union { … } }` with a struct for the fields of each variant; none without fields |
//! | `Option<T>` | `struct { bool is_some; T value; }` |
//! | `heapless::Vec<T, N>` as a field | `struct { uint32_t length; T elements[N]; }` |
//! | `heapless::String<N>` as a field | `struct { uint32_t length; char text[N]; }` |
//!
//! All padding bytes are 0 when they are sent, and are ignored when they are received.
use core::ops::Range;

use super::{FixedPayload, PayloadError};

/// A value that can be a field of a struct, an element of an array and the like: any [`FixedPayload`], and lists and
/// texts, which then have a slot of their full size.
#[diagnostic::on_unimplemented(
    message = "a value of type `{Self}` cannot stand in a struct, an enum or a list that is sent to another federate",
    label = "it cannot be sent",
    note = "for text write `heapless::String<N>`, for a list `heapless::Vec<T, N>`, for `usize` a fixed size such as \
            `u32`, and before a struct or an enum of your own `#[derive(Payload)]`"
)]
pub trait Field: Sized {
    /// Its size and its alignment.
    const LAYOUT: Layout;

    /// Writes it to `bytes`, as many as its layout has, all of them 0.
    fn write_field(&self, bytes: &mut [u8]);

    /// Reads it from `bytes`, as many as its layout has.
    ///
    /// # Errors
    /// When the bytes are not a value of this type.
    fn read_field(bytes: &[u8]) -> Result<Self, PayloadError>;
}

#[diagnostic::do_not_recommend]
impl<T: FixedPayload> Field for T {
    const LAYOUT: Layout = Layout::new(T::SIZE, T::ALIGN);

    fn write_field(&self, bytes: &mut [u8]) {
        self.write(bytes);
    }

    fn read_field(bytes: &[u8]) -> Result<Self, PayloadError> {
        Self::read(bytes)
    }
}

/// Size and alignment of a C type, or of its first fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The end of the last field.
    end: usize,
    align: usize,
}

impl Layout {
    /// A struct without fields.
    pub const EMPTY: Self = Self { end: 0, align: 1 };

    /// Returns a type of this size and this alignment.
    ///
    /// # Panics
    /// When the alignment is not a power of two: while compiling, because layouts are constants.
    pub const fn new(size: usize, align: usize) -> Self {
        assert!(align.is_power_of_two(), "an alignment is a power of two");
        Self { end: size, align }
    }

    /// Returns the struct with one more field.
    #[must_use]
    pub const fn with(self, field: Self) -> Self {
        let start = self.end.next_multiple_of(field.align);
        Self { end: start + field.size(), align: max(self.align, field.align) }
    }

    /// Returns the union with one more member.
    #[must_use]
    pub const fn or(self, member: Self) -> Self {
        Self { end: max(self.end, member.size()), align: max(self.align, member.align) }
    }

    /// Returns the array with this many elements.
    #[must_use]
    pub const fn times(self, elements: usize) -> Self {
        Self { end: elements * self.size(), align: self.align }
    }

    /// Returns its size in bytes, with the padding at the end.
    pub const fn size(self) -> usize {
        self.end.next_multiple_of(self.align)
    }

    /// Returns the alignment of its address.
    pub const fn align(self) -> usize {
        self.align
    }
}

const fn max(one: usize, other: usize) -> usize {
    if one > other { one } else { other }
}

/// The layout and the functions for fields of one type.
#[derive(Debug)]
pub struct Member<T> {
    /// Size and alignment.
    pub layout: Layout,
    write: fn(&T, &mut [u8]),
    read: fn(&[u8]) -> Result<T, PayloadError>,
}

/// Returns the member of a type. The code that `#[derive(Payload)]` generates uses nothing else of a field, so that
/// rustc reports a missing implementation once.
pub const fn member<T: Field>() -> Member<T> {
    Member { layout: T::LAYOUT, write: T::write_field, read: T::read_field }
}

/// The fields of a struct, one after the other.
#[derive(Debug)]
pub struct Fields<B> {
    bytes: B,
    end: usize,
}

impl<B> Fields<B> {
    /// Returns the fields in all these bytes of a struct; for writing they are 0.
    pub const fn new(bytes: B) -> Self {
        Self { bytes, end: 0 }
    }

    /// Moves to the beginning of a union of this layout.
    pub const fn align_to(&mut self, union: Layout) {
        self.end = self.end.next_multiple_of(union.align);
    }

    const fn next(&mut self, layout: Layout) -> Range<usize> {
        let start = self.end.next_multiple_of(layout.align);
        self.end = start + layout.size();
        start..self.end
    }
}

impl Fields<&mut [u8]> {
    /// Writes the next field.
    ///
    /// # Panics
    /// When the bytes are fewer than the struct's layout has.
    #[expect(clippy::needless_pass_by_value, reason = "it is a constant, which is made where it is used")]
    pub fn put<T>(&mut self, member: Member<T>, value: &T) {
        let place = self.next(member.layout);
        (member.write)(value, &mut self.bytes[place]);
    }
}

impl Fields<&[u8]> {
    /// Reads the next field.
    ///
    /// # Errors
    /// When the bytes are not a value of this type.
    ///
    /// # Panics
    /// When the bytes are fewer than the struct's layout has.
    #[expect(clippy::needless_pass_by_value, reason = "it is a constant, which is made where it is used")]
    pub fn take<T>(&mut self, member: Member<T>) -> Result<T, PayloadError> {
        let place = self.next(member.layout);
        (member.read)(&self.bytes[place])
    }
}
