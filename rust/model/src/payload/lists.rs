// SPDX-License-Identifier: Apache-2.0
//! Lists and texts: a value by itself takes as many bytes as it has, a field of a struct a length and a slot of full
//! size.
use super::compound::write_elements;
use super::layout::{Field, Fields, Layout, member};
use super::{Payload, PayloadError};

impl<T: Field, const N: usize> Payload for heapless::Vec<T, N> {
    const MAX_LEN: usize = {
        assert!(T::LAYOUT.size() > 0, "a list of elements without bytes has no length to send");
        N * T::LAYOUT.size()
    };

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        list_to(self, N, bytes)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        list_from(bytes, N)
    }
}

impl<const N: usize> Payload for heapless::String<N> {
    const MAX_LEN: usize = N + 1;

    fn encode(&self, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        text_to(self, N, bytes)
    }

    fn decode(bytes: &[u8]) -> Result<Self, PayloadError> {
        let text = text_from(bytes)?;
        text.try_into().map_err(|_| PayloadError::TooLong { capacity: N, found: text.len() })
    }
}

/// Writes the elements of a list that holds at most `capacity`, and returns the number of bytes.
///
/// # Errors
/// When the list is longer, or the bytes do not fit.
pub fn list_to<T: Field>(elements: &[T], capacity: usize, bytes: &mut [u8]) -> Result<usize, PayloadError> {
    let (needed, available) = (elements.len() * T::LAYOUT.size(), bytes.len());
    if elements.len() > capacity {
        return Err(PayloadError::TooLong { capacity, found: elements.len() });
    }
    let room = bytes.get_mut(..needed).ok_or(PayloadError::NoRoom { needed, available })?;
    write_elements(elements, room);
    Ok(needed)
}

/// Reads a list that holds at most `capacity` elements, each of which has at least one byte.
///
/// # Errors
/// When there are more, or a part of one, or one that is not a value of its type.
pub fn list_from<T: Field, L: FromIterator<T>>(bytes: &[u8], capacity: usize) -> Result<L, PayloadError> {
    let elements = bytes.chunks_exact(T::LAYOUT.size().max(1));
    if !elements.remainder().is_empty() {
        return Err(PayloadError::Remainder { element: T::LAYOUT.size(), found: bytes.len() });
    }
    if elements.len() > capacity {
        return Err(PayloadError::TooLong { capacity, found: elements.len() });
    }
    elements.map(T::read_field).collect()
}

/// Writes a text of at most `capacity` bytes and a NUL, and returns the number of bytes.
///
/// # Errors
/// When the text is longer, has a NUL, or does not fit.
pub fn text_to(text: &str, capacity: usize, bytes: &mut [u8]) -> Result<usize, PayloadError> {
    let (needed, available) = (text.len() + 1, bytes.len());
    if text.len() > capacity {
        return Err(PayloadError::TooLong { capacity, found: text.len() });
    }
    let room = bytes.get_mut(..needed).ok_or(PayloadError::NoRoom { needed, available })?;
    if text.as_bytes().contains(&0) {
        return Err(PayloadError::Nul);
    }
    let (place, nul) = room.split_at_mut(text.len());
    place.copy_from_slice(text.as_bytes());
    nul.fill(0);
    Ok(needed)
}

/// Reads a text that ends with a NUL.
///
/// # Errors
/// When it does not, has a NUL inside, or is not UTF-8.
pub fn text_from(bytes: &[u8]) -> Result<&str, PayloadError> {
    let Some((0, text)) = bytes.split_last() else { return Err(PayloadError::Nul) };
    if text.contains(&0) {
        return Err(PayloadError::Nul);
    }
    core::str::from_utf8(text).map_err(|_| PayloadError::NotUtf8)
}

/// Returns the length of a slot in the form that precedes the slot.
const fn length(length: usize) -> u32 {
    assert!(length <= u32::MAX as usize, "a slot has at most u32::MAX elements");
    #[expect(clippy::cast_possible_truncation, reason = "it has just been compared")]
    let length = length as u32;
    length
}

/// Returns the length, if it is at most `capacity`, and the bytes behind it.
fn slot(bytes: &[u8], elements: Layout, capacity: usize) -> Result<(usize, &[u8]), PayloadError> {
    let mut fields = Fields::new(bytes);
    let length: u32 = fields.take(member())?;
    let found = usize::try_from(length).unwrap_or(usize::MAX);
    if found > capacity {
        return Err(PayloadError::TooLong { capacity, found });
    }
    Ok((found, &bytes[u32::LAYOUT.size().next_multiple_of(elements.align())..]))
}

impl<T: Field, const N: usize> Field for heapless::Vec<T, N> {
    const LAYOUT: Layout = {
        length(N);
        Layout::EMPTY.with(u32::LAYOUT).with(T::LAYOUT.times(N))
    };

    fn write_field(&self, bytes: &mut [u8]) {
        bytes.fill(0);
        let start = u32::LAYOUT.size().next_multiple_of(T::LAYOUT.align());
        Fields::new(&mut *bytes).put(member(), &length(self.len()));
        write_elements(self, &mut bytes[start..]);
    }

    fn read_field(bytes: &[u8]) -> Result<Self, PayloadError> {
        let (length, elements) = slot(bytes, T::LAYOUT, N)?;
        let size = T::LAYOUT.size();
        (0..length).map(|index| T::read_field(&elements[index * size..(index + 1) * size])).collect()
    }
}

impl<const N: usize> Field for heapless::String<N> {
    const LAYOUT: Layout = <heapless::Vec<u8, N> as Field>::LAYOUT;

    fn write_field(&self, bytes: &mut [u8]) {
        bytes.fill(0);
        let (before, text) = bytes.split_at_mut(u32::LAYOUT.size());
        Fields::new(before).put(member(), &length(self.len()));
        text[..self.len()].copy_from_slice(self.as_bytes());
    }

    fn read_field(bytes: &[u8]) -> Result<Self, PayloadError> {
        let (length, text) = slot(bytes, u8::LAYOUT, N)?;
        let text = core::str::from_utf8(&text[..length]).map_err(|_| PayloadError::NotUtf8)?;
        text.try_into().map_err(|_| PayloadError::TooLong { capacity: N, found: text.len() })
    }
}
