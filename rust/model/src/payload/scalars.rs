// SPDX-License-Identifier: Apache-2.0
//! Scalar values, and the value without bytes.
use core::time::Duration;

use super::{FixedPayload, PayloadError};
use crate::time::{Instant, Interval};

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
    Instant, |instant| instant.as_nanos(), Instant::from_nanos;
    Interval, |interval| interval.as_nanos(), Interval::from_nanos;
    Duration, |duration| Interval::from_duration(duration).as_nanos(), |ns| Interval::from_nanos(ns).to_duration()
);

/// The form of C's `char32_t`.
impl FixedPayload for char {
    const SIZE: usize = u32::SIZE;
    const ALIGN: usize = u32::ALIGN;
    fn write(&self, bytes: &mut [u8]) {
        u32::from(*self).write(bytes);
    }
    fn read(bytes: &[u8]) -> Result<Self, PayloadError> {
        let number = u32::read(bytes)?;
        Self::from_u32(number).ok_or(PayloadError::NotChar(number))
    }
}
