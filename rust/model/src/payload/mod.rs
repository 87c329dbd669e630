// SPDX-License-Identifier: Apache-2.0
//! Values as bytes between federates: the memory of the C type, little-endian, as the stock runtime sends it.
//!
//! A scalar takes its size, an array length × element, a struct or tuple the C layout with its padding, an enum that of
//! a number and a union, a `heapless::Vec` the elements that it holds, a `heapless::String` its bytes and a NUL, a time
//! 8 bytes of nanoseconds, and `()` nothing. Within a struct, a value of variable length has a slot of its full size:
//! [`layout`]. `usize` has no form as bytes, because it differs between a computer and a board.
use core::fmt;

use lf_texts::say;

mod compound;
pub mod layout;
mod lists;
mod scalars;
mod serializer;

pub use lists::{list_from, list_to, text_from, text_to};
#[cfg(feature = "postcard")]
pub use serializer::{Bounded, Postcard};
pub use serializer::{Native, Serializer, copied_by_connection, sendable, sendable_by};

/// A value that can be sent to another federate.
#[diagnostic::on_unimplemented(
    message = "a value of type `{Self}` cannot be sent to another federate",
    label = "it goes to another federate",
    note = "write `#[derive(Payload)]` before a struct or an enum of your own; a type of serde can be sent with \
            `@serializer(\"postcard\")` before the port",
    note = "sent are integers of a fixed size, bool, char, f32, f64, Duration, arrays, tuples, Option, heapless::Vec, \
            heapless::String, and structs and enums of these"
)]
pub trait Payload: Sized {
    /// The maximum number of bytes of a value; the generator sizes buffers by it.
    const MAX_LEN: usize;

    /// Writes the value to the beginning of `bytes`, and returns the number of bytes.
    ///
    /// # Errors
    /// When they do not fit, or the value has no form as bytes.
    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError>;

    /// Reads a value from all of `bytes`.
    ///
    /// # Errors
    /// When they are not one value of this type.
    fn decode(bytes: &[u8]) -> Result<Self, PayloadError>;
}

/// A value that always takes the same number of bytes, so that it can be a field of a struct or an element of an array.
#[diagnostic::on_unimplemented(
    message = "a value of type `{Self}` does not always take the same number of bytes",
    note = "write `#[derive(Payload)]` before a struct or an enum of your own"
)]
pub trait FixedPayload: Sized {
    /// Its size in bytes.
    const SIZE: usize;

    /// Its alignment, as in C on 64-bit Linux and 32-bit Arm.
    const ALIGN: usize;

    /// Writes it to `bytes`, exactly [`SIZE`](Self::SIZE).
    fn write(&self, bytes: &mut [u8]);

    /// Reads it from `bytes`, exactly [`SIZE`](Self::SIZE).
    ///
    /// # Errors
    /// When the bytes are not a value of this type.
    fn read(bytes: &[u8]) -> Result<Self, PayloadError>;
}

/// The reason why bytes and values do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PayloadError {
    /// There is no value to write.
    Absent,
    /// The bytes to write to are too few.
    NoRoom {
        /// Bytes that the value takes.
        needed: usize,
        /// Bytes that there are.
        available: usize,
    },
    /// The bytes to read from are too few or too many.
    Length {
        /// Bytes that the type takes.
        expected: usize,
        /// Bytes that there are.
        found: usize,
    },
    /// The bytes are not a whole number of elements.
    Remainder {
        /// Bytes of one element.
        element: usize,
        /// Bytes that there are.
        found: usize,
    },
    /// There is more than the type can hold.
    TooLong {
        /// Elements, or bytes of text, that fit.
        capacity: usize,
        /// The number found.
        found: usize,
    },
    /// A byte is neither 0 nor 1.
    NotBool(u8),
    /// A text does not end with NUL, or has one inside.
    Nul,
    /// A text is not UTF-8.
    NotUtf8,
    /// A number is not a character.
    NotChar(u32),
    /// A number is none of the enum's variants.
    NotVariant(i64),
    /// A serialized value takes more bytes than its bound.
    LongerThan(usize),
    /// The serializer has no form for the value.
    NotSerialized,
    /// The serializer finds no value of the type, or more than it.
    NotDeserialized,
}

impl fmt::Display for PayloadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => say!(f, "there is no value"),
            Self::NoRoom { needed, available } => say!(f, "it takes {needed} bytes, but there are {available}"),
            Self::Length { expected, found } => say!(f, "its type takes {expected} bytes, but it has {found}"),
            Self::Remainder { element, found } => {
                say!(f, "its elements take {element} bytes each, which does not divide {found}")
            }
            Self::TooLong { capacity, found } => say!(f, "its type holds {capacity} elements, but it has {found}"),
            Self::NotBool(byte) => say!(f, "a truth value is 0 or 1, but it has {byte}"),
            Self::Nul => say!(f, "a text ends with its only NUL byte, but it has one elsewhere or none"),
            Self::NotUtf8 => say!(f, "a text is UTF-8, but it is not"),
            Self::NotChar(number) => say!(f, "a character is a Unicode scalar value, but it has {number:#x}"),
            Self::NotVariant(number) => say!(f, "no variant of its type has the number {number}"),
            Self::LongerThan(bound) => say!(f, "it takes more than the {bound} bytes that its bound allows"),
            Self::NotSerialized => say!(f, "its serializer cannot write it"),
            Self::NotDeserialized => say!(f, "its serializer does not find a value of its type in it"),
        }
    }
}

impl core::error::Error for PayloadError {}

#[diagnostic::do_not_recommend]
impl<T: FixedPayload> Payload for T {
    const MAX_LEN: usize = T::SIZE;

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let available = bytes.len();
        let room = bytes.get_mut(..T::SIZE).ok_or(PayloadError::NoRoom { needed: T::SIZE, available })?;
        self.write(room);
        Ok(T::SIZE)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        if bytes.len() != T::SIZE {
            return Err(PayloadError::Length { expected: T::SIZE, found: bytes.len() });
        }
        T::read(bytes)
    }
}

/// Declares a struct or an enum that can be sent to another federate: the same as `#[derive(Payload)]` before it.
///
/// ```
/// lf_model::payload! {
///     #[derive(Clone, Copy, Debug, PartialEq)]
///     pub struct Reading {
///         pub unit: u8,
///         pub volts: f64,
///     }
/// }
/// use lf_model::Payload;
/// assert_eq!(Reading::MAX_LEN, 16);
/// ```
#[macro_export]
macro_rules! payload {
    ($($item:tt)*) => {
        #[derive($crate::Payload)]
        #[payload(crate = $crate)]
        $($item)*
    };
}
