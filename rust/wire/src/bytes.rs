// SPDX-License-Identifier: Apache-2.0
//! A reader and a writer of little-endian fields that cannot leave their slice.

use lf_derive::outlined;

use crate::{NoRoom, Tag};

/// The bytes end before the field does.
pub(crate) struct Short {
    /// The minimum number of bytes, from the beginning, that the field needs.
    pub(crate) need: usize,
}

/// Reads field after field from the beginning of `bytes`.
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Returns the offset of the next field.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Checks early that there are `end` bytes for the next fields, so that a caller learns the whole need at once.
    pub(crate) fn require(&self, end: usize) -> Result<(), Short> {
        if self.bytes.len() < end { Err(Short { need: end }) } else { Ok(()) }
    }

    pub(crate) fn take(&mut self, len: usize) -> Result<&'a [u8], Short> {
        let end = self.at.saturating_add(len);
        let field = self.bytes.get(self.at..end).ok_or(Short { need: end })?;
        self.at = end;
        Ok(field)
    }

    /// Reads a field of a fixed length; zeros where bytes are missing, which [`Reader::require`] finds out for all at
    /// once.
    pub(crate) fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut field = [0; N];
        if let Ok(bytes) = self.take(N) {
            field.copy_from_slice(bytes);
        }
        field
    }

    pub(crate) fn u8(&mut self) -> u8 {
        u8::from_le_bytes(self.array())
    }

    /// Reads a byte that is 0 or 1, if it is there; leaves any other byte to the next field.
    pub(crate) fn flag(&mut self) -> Option<bool> {
        let flag = self.bytes.get(self.at).filter(|byte| **byte <= 1).map(|byte| *byte == 1);
        self.at += usize::from(flag.is_some());
        flag
    }

    pub(crate) fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    pub(crate) fn i32(&mut self) -> i32 {
        i32::from_le_bytes(self.array())
    }

    pub(crate) fn i64(&mut self) -> i64 {
        i64::from_le_bytes(self.array())
    }

    pub(crate) fn tag(&mut self) -> Tag {
        Tag { time: self.i64(), microstep: self.u32() }
    }
}

/// Writes field after field into as many bytes as they need, and nothing behind the last byte.
pub(crate) struct Writer<'b> {
    bytes: &'b mut [u8],
    at: usize,
}

impl<'b> Writer<'b> {
    /// Takes the first `len` bytes of `bytes`; fails, without writing, if there are fewer.
    pub(crate) fn new(bytes: &'b mut [u8], len: usize) -> Result<Self, NoRoom> {
        let room = bytes.len();
        let bytes = bytes.get_mut(..len).ok_or(NoRoom { needed: len, room })?;
        Ok(Self { bytes, at: 0 })
    }

    #[outlined]
    pub(crate) fn put(&mut self, field: &[u8]) {
        let end = self.at.saturating_add(field.len());
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(field);
        }
        self.at = end;
    }

    pub(crate) fn u8(&mut self, value: u8) {
        self.put(&[value]);
    }

    /// Writes a byte for yes or no, if there is a value.
    pub(crate) fn flag(&mut self, value: Option<bool>) {
        if let Some(value) = value {
            self.u8(value.into());
        }
    }

    pub(crate) fn u16(&mut self, value: u16) {
        self.put(&value.to_le_bytes());
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.put(&value.to_le_bytes());
    }

    pub(crate) fn i32(&mut self, value: i32) {
        self.put(&value.to_le_bytes());
    }

    pub(crate) fn i64(&mut self, value: i64) {
        self.put(&value.to_le_bytes());
    }

    pub(crate) fn tag(&mut self, value: Tag) {
        self.i64(value.time);
        self.u32(value.microstep);
    }
}
