// SPDX-License-Identifier: Apache-2.0
//! Values as bytes between federates: the memory of the C type, little-endian, as the stock runtime sends it.
//!
//! Scalars take their size, arrays length × element, structs the C layout with its padding, `heapless::Vec` as many
//! elements as it holds, `heapless::String` its bytes and a NUL, times 8 bytes of nanoseconds, and `()` nothing.
//! `usize` has no form as bytes, because it differs between a computer and a board.
use core::fmt;
use core::time::Duration;

use crate::time::{Instant, Interval};

/// A value that can be sent to another federate.
#[diagnostic::on_unimplemented(
    message = "a value of type `{Self}` cannot be sent to another federate",
    note = "sent are integers of a fixed size, bool, f32, f64, Duration, arrays, heapless::Vec, heapless::String, and \
            structs that are declared in `payload! {{ … }}`"
)]
pub trait Payload: Sized {
    /// The most bytes that a value takes; the generator sizes buffers by it.
    const MAX_LEN: usize;

    /// Writes the value to the beginning of `bytes`, and gives the number of bytes.
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

/// A value that always takes the same number of bytes, so that it can stand in a struct or an array.
#[diagnostic::on_unimplemented(
    message = "a value of type `{Self}` cannot stand in an array or a struct that is sent to another federate",
    note = "there can stand integers of a fixed size, bool, f32, f64, Duration, arrays of these, and structs that are \
            declared in `payload! {{ … }}`"
)]
pub trait FixedPayload: Sized {
    /// Its bytes.
    const SIZE: usize;

    /// Its address is a multiple of this, as in C on 64-bit Linux and 32-bit Arm.
    const ALIGN: usize;

    /// Writes it to `bytes`, which are [`SIZE`](Self::SIZE).
    fn write(&self, bytes: &mut [u8]);

    /// Reads it from `bytes`, which are [`SIZE`](Self::SIZE).
    ///
    /// # Errors
    /// When the bytes are not a value of this type.
    fn read(bytes: &[u8]) -> Result<Self, PayloadError>;
}

/// Bytes and values that do not go together.
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
    /// The bytes are no whole number of elements.
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
        /// Those that there are.
        found: usize,
    },
    /// A byte is neither 0 nor 1.
    NotBool(u8),
    /// A text does not end with NUL, or has one inside.
    Nul,
    /// A text is not UTF-8.
    NotUtf8,
}

impl fmt::Display for PayloadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => f.write_str("there is no value"),
            Self::NoRoom { needed, available } => write!(f, "it takes {needed} bytes, but there are {available}"),
            Self::Length { expected, found } => write!(f, "its type takes {expected} bytes, but it has {found}"),
            Self::Remainder { element, found } => {
                write!(f, "its elements take {element} bytes each, which does not divide {found}")
            }
            Self::TooLong { capacity, found } => write!(f, "its type holds {capacity} elements, but it has {found}"),
            Self::NotBool(byte) => write!(f, "a truth value is 0 or 1, but it has {byte}"),
            Self::Nul => f.write_str("a text ends with its only NUL byte, but it has one elsewhere or none"),
            Self::NotUtf8 => f.write_str("a text is UTF-8, but it is not"),
        }
    }
}

impl core::error::Error for PayloadError {}

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

macro_rules! scalars {
    ($($scalar:ty),+) => {$(
        impl FixedPayload for $scalar {
            const SIZE: usize = size_of::<$scalar>();
            const ALIGN: usize = size_of::<$scalar>();
            fn write(&self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_le_bytes());
            }
            fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
                let length = PayloadError::Length { expected: Self::SIZE, found: bytes.len() };
                Ok(Self::from_le_bytes(bytes.try_into().map_err(|_| length)?))
            }
        }
    )+};
}
scalars!(u8, u16, u32, u64, i8, i16, i32, i64, f32, f64);

impl FixedPayload for () {
    const SIZE: usize = 0;
    const ALIGN: usize = 1;
    fn write(&self, _bytes: &mut [u8]) {}
    fn read(_bytes: &[u8]) -> Result<Self, PayloadError> {
        Ok(())
    }
}

impl FixedPayload for bool {
    const SIZE: usize = 1;
    const ALIGN: usize = 1;
    fn write(&self, bytes: &mut [u8]) {
        u8::from(*self).write(bytes);
    }
    fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
        match u8::read(bytes)? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(PayloadError::NotBool(other)),
        }
    }
}

macro_rules! times {
    ($($time:ty, $to:expr, $from:expr);+) => {$(
        impl FixedPayload for $time {
            const SIZE: usize = i64::SIZE;
            const ALIGN: usize = i64::ALIGN;
            fn write(&self, bytes: &mut [u8]) {
                let to: fn($time) -> i64 = $to;
                to(*self).write(bytes);
            }
            fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
                i64::read(bytes).map($from)
            }
        }
    )+};
}
times!(
    Instant, |instant| instant.0, Instant;
    Interval, |interval| interval.0, Interval;
    Duration, |duration| Interval::from_duration(duration).0, |ns| Interval(ns).to_duration()
);

impl<T: FixedPayload, const N: usize> FixedPayload for [T; N] {
    const SIZE: usize = N * T::SIZE;
    const ALIGN: usize = T::ALIGN;

    fn write(&self, bytes: &mut [u8]) {
        write_all(self, bytes);
    }

    fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
        let mut elements = heapless::Vec::<T, N>::new();
        for index in 0..N {
            // It fits: the list has room for as many elements as are read.
            let _ = elements.push(T::read(&bytes[index * T::SIZE..(index + 1) * T::SIZE])?);
        }
        elements
            .into_array()
            .map_err(|short| PayloadError::Length { expected: Self::SIZE, found: short.len() * T::SIZE })
    }
}

fn write_all<T: FixedPayload>(elements: &[T], bytes: &mut [u8]) {
    for (index, element) in elements.iter().enumerate() {
        element.write(&mut bytes[index * T::SIZE..(index + 1) * T::SIZE]);
    }
}

impl<T: FixedPayload, const N: usize> Payload for heapless::Vec<T, N> {
    const MAX_LEN: usize = {
        assert!(T::SIZE > 0, "a list of elements without bytes has no length to send");
        N * T::SIZE
    };

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let (needed, available) = (self.len() * T::SIZE, bytes.len());
        let room = bytes.get_mut(..needed).ok_or(PayloadError::NoRoom { needed, available })?;
        write_all(self, room);
        Ok(needed)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        if bytes.len() > Self::MAX_LEN {
            return Err(PayloadError::TooLong { capacity: N, found: bytes.len() / T::SIZE });
        }
        let elements = bytes.chunks_exact(T::SIZE);
        if !elements.remainder().is_empty() {
            return Err(PayloadError::Remainder { element: T::SIZE, found: bytes.len() });
        }
        elements.map(T::read).collect()
    }
}

impl<const N: usize> Payload for heapless::String<N> {
    const MAX_LEN: usize = N + 1;

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        let (needed, available) = (self.len() + 1, bytes.len());
        let room = bytes.get_mut(..needed).ok_or(PayloadError::NoRoom { needed, available })?;
        if self.as_bytes().contains(&0) {
            return Err(PayloadError::Nul);
        }
        let (text, nul) = room.split_at_mut(self.len());
        text.copy_from_slice(self.as_bytes());
        nul.fill(0);
        Ok(needed)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        let Some((0, text)) = bytes.split_last() else { return Err(PayloadError::Nul) };
        if text.contains(&0) {
            return Err(PayloadError::Nul);
        }
        let text = core::str::from_utf8(text).map_err(|_| PayloadError::NotUtf8)?;
        text.try_into().map_err(|_| PayloadError::TooLong { capacity: N, found: text.len() })
    }
}

/// Declares a struct that can be sent to another federate, laid out as C lays out a struct of these fields.
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
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident: $type:ty),* $(,)?
        }
    ) => {
        $(#[$attribute])*
        $visibility struct $name {
            $($(#[$field_attribute])* $field_visibility $field: $type),*
        }

        impl $crate::FixedPayload for $name {
            const ALIGN: usize = {
                let mut align = 1;
                $(if <$type as $crate::FixedPayload>::ALIGN > align {
                    align = <$type as $crate::FixedPayload>::ALIGN;
                })*
                align
            };

            const SIZE: usize = {
                let mut end: usize = 0;
                $(end = end.next_multiple_of(<$type as $crate::FixedPayload>::ALIGN)
                    + <$type as $crate::FixedPayload>::SIZE;)*
                end.next_multiple_of(<Self as $crate::FixedPayload>::ALIGN)
            };

            #[allow(unused_assignments, unused_mut, unused_variables)]
            fn write(&self, bytes: &mut [u8]) {
                bytes.fill(0);
                let mut end: usize = 0;
                $(
                    let start = end.next_multiple_of(<$type as $crate::FixedPayload>::ALIGN);
                    end = start + <$type as $crate::FixedPayload>::SIZE;
                    $crate::FixedPayload::write(&self.$field, &mut bytes[start..end]);
                )*
            }

            #[allow(unused_assignments, unused_mut, unused_variables)]
            fn read(bytes: &[u8]) -> ::core::result::Result<Self, $crate::PayloadError> {
                let mut end: usize = 0;
                $(
                    let start = end.next_multiple_of(<$type as $crate::FixedPayload>::ALIGN);
                    end = start + <$type as $crate::FixedPayload>::SIZE;
                    let $field = <$type as $crate::FixedPayload>::read(&bytes[start..end])?;
                )*
                ::core::result::Result::Ok(Self { $($field),* })
            }
        }
    };
}
