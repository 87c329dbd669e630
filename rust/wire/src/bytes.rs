// SPDX-License-Identifier: Apache-2.0
//! A reader and a writer of little-endian fields that cannot leave their slice.

use crate::{NoRoom, Tag};

/// The bytes end before the field does.
pub(crate) struct Short {
    /// Bytes, from the beginning, that the field needs at least.
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

    /// Offset of the next field.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Says early that the fields to come end at `end` or later, so that a caller learns the whole need at once.
    pub(crate) fn require(&self, end: usize) -> Result<(), Short> {
        if self.bytes.len() < end { Err(Short { need: end }) } else { Ok(()) }
    }

    pub(crate) fn take(&mut self, len: usize) -> Result<&'a [u8], Short> {
        let end = self.at.saturating_add(len);
        let field = self.bytes.get(self.at..end).ok_or(Short { need: end })?;
        self.at = end;
        Ok(field)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Result<[u8; N], Short> {
        let end = self.at.saturating_add(N);
        let field = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk).ok_or(Short { need: end })?;
        self.at = end;
        Ok(*field)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Short> {
        self.array().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Short> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Short> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn i32(&mut self) -> Result<i32, Short> {
        self.array().map(i32::from_le_bytes)
    }

    pub(crate) fn i64(&mut self) -> Result<i64, Short> {
        self.array().map(i64::from_le_bytes)
    }

    pub(crate) fn tag(&mut self) -> Result<Tag, Short> {
        Ok(Tag { time: self.i64()?, microstep: self.u32()? })
    }
}

/// Writes field after field into exactly as many bytes as they need.
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

    pub(crate) fn put(&mut self, field: &[u8]) -> Result<(), NoRoom> {
        let free = self.bytes.get_mut(self.at..).unwrap_or_default();
        let no_room = NoRoom { needed: field.len(), room: free.len() };
        free.get_mut(..field.len()).ok_or(no_room)?.copy_from_slice(field);
        self.at += field.len();
        Ok(())
    }

    pub(crate) fn u8(&mut self, value: u8) -> Result<(), NoRoom> {
        self.put(&[value])
    }

    pub(crate) fn u16(&mut self, value: u16) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn u32(&mut self, value: u32) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn i32(&mut self, value: i32) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn i64(&mut self, value: i64) -> Result<(), NoRoom> {
        self.put(&value.to_le_bytes())
    }

    pub(crate) fn tag(&mut self, value: Tag) -> Result<(), NoRoom> {
        self.i64(value.time)?;
        self.u32(value.microstep)
    }
}
