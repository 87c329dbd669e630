// SPDX-License-Identifier: Apache-2.0
//! Memory of a buffer that grows for long messages and shrinks after them.

use std::vec;
use std::vec::Vec;

use lf_wire::Storage;

/// Memory of a buffer, on the heap. An empty buffer that was not used much is short, and only a single message makes it
/// longer than usual.
pub struct Growing {
    bytes: Vec<u8>,
    idle: usize,
    usual: usize,
    max: usize,
}

impl Growing {
    /// Returns memory of `idle` bytes, which can grow to `max` or `usual` bytes, whichever is more. Up to `usual` it
    /// keeps the length that it has reached, so that a stream of messages does not cost memory management. A buffer for
    /// reading needs an `idle` and a `usual` of at least 1, because nothing comes into a buffer without space.
    pub fn new(idle: usize, usual: usize, max: usize) -> Self {
        let max = max.max(usual);
        let idle = idle.min(usual);
        Self { bytes: vec![0; idle], idle, usual, max }
    }
}

impl std::fmt::Debug for Growing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Growing").field("bytes", &self.bytes.len()).field("max", &self.max).finish_non_exhaustive()
    }
}

impl AsRef<[u8]> for Growing {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

impl AsMut<[u8]> for Growing {
    fn as_mut(&mut self) -> &mut [u8] {
        &mut self.bytes
    }
}

impl Storage for Growing {
    fn bytes_usual(&self) -> usize {
        self.usual
    }

    fn bytes_max(&self) -> usize {
        self.max
    }

    fn grow(&mut self, bytes: usize) -> bool {
        let more = bytes.saturating_sub(self.bytes.len());
        if bytes > self.max || self.bytes.try_reserve_exact(more).is_err() {
            return false;
        }
        self.bytes.resize(bytes, 0);
        true
    }

    fn shrink(&mut self) {
        self.bytes.truncate(self.idle);
        self.bytes.shrink_to_fit();
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use lf_wire::{Decoded, InBuffer, Limits, Message, OutBuffer, Storage, Tag, decode};
    use proptest::prelude::*;

    use super::Growing;

    const TAG: Tag = Tag { time: 1, microstep: 2 };

    fn message(payload: &[u8]) -> Message<'_> {
        Message::TaggedMessage { port: 1, federate: 2, tag: TAG, payload }
    }

    fn payload(index: usize, length: usize) -> Vec<u8> {
        (0..length).map(|at| u8::try_from((index * 31 + at) % 251).unwrap()).collect()
    }

    /// Moves bytes from one buffer to the other in pieces, and checks each complete message.
    fn carry(
        out: &mut OutBuffer<Growing>,
        input: &mut InBuffer<Growing>,
        piece: usize,
        next: &mut usize,
        of: &[usize],
    ) {
        loop {
            let space = input.space();
            let count = out.pending().len().min(space.len()).min(piece);
            space[..count].copy_from_slice(&out.pending()[..count]);
            input.filled(count);
            out.consume(count);
            out.shrink();
            loop {
                match decode(input.bytes(), &Limits::NONE).unwrap() {
                    Decoded::Complete { message: found, len } => {
                        assert_eq!(found, message(&payload(*next, of[*next])));
                        *next += 1;
                        input.consume(len);
                    }
                    Decoded::Incomplete { need, .. } => {
                        assert!(input.make_space_for(need));
                        break;
                    }
                }
            }
            input.shrink();
            if out.is_empty() {
                return;
            }
        }
    }

    proptest! {
        /// Messages of any length and in any pieces go through both buffers unchanged, and in the end no more memory is
        /// kept than usual.
        #[test]
        fn messages_go_through_buffers_that_grow_and_shrink(
            lengths in proptest::collection::vec(prop_oneof![0usize..40, 0usize..2000], 1..40),
            piece in 1usize..700,
            idle in 1usize..64,
            usual in 1usize..300,
        ) {
            let mut out = OutBuffer::new(Growing::new(idle, usual, 3000));
            let mut input = InBuffer::new(Growing::new(idle, usual, 3000));
            let mut next = 0;
            for (index, length) in lengths.iter().enumerate() {
                let payload = payload(index, *length);
                let message = message(&payload);
                if out.room_max() < message.encoded_len() {
                    carry(&mut out, &mut input, piece, &mut next, &lengths);
                }
                prop_assert!(out.room_max() >= message.encoded_len());
                prop_assert!(out.make_room(message.encoded_len()));
                out.push(&message).unwrap();
                prop_assert!(out.capacity() <= usual.max(out.pending().len()).max(idle));
            }
            carry(&mut out, &mut input, piece, &mut next, &lengths);
            prop_assert_eq!(next, lengths.len());
            prop_assert!(out.capacity() <= usual && input.capacity() <= usual);
        }
    }

    #[test]
    fn an_announced_length_costs_no_more_than_twice_what_has_come() {
        let max = u32::MAX as usize + 21;
        let mut input = InBuffer::new(Growing::new(64, 256, max));
        let mut header = vec![5, 0, 0, 1, 0];
        header.extend(u32::MAX.to_le_bytes());
        header.extend([0; 12]);
        let mut came = 0;
        for byte in header.into_iter().chain(std::iter::repeat_n(7, 3000)) {
            input.space()[0] = byte;
            input.filled(1);
            came += 1;
            let Ok(Decoded::Incomplete { need, .. }) = decode(input.bytes(), &Limits::NONE) else { panic!("it is") };
            assert!(input.make_space_for(need));
            assert!(input.capacity() <= 64.max(2 * came), "{} bytes for {came}", input.capacity());
        }
        input.clear();
        input.shrink();
        assert_eq!(input.capacity(), 64);
    }

    #[test]
    fn a_buffer_that_cannot_grow_refuses_and_loses_nothing() {
        let mut input = InBuffer::new(Growing::new(4, 4, 6));
        input.space().copy_from_slice(b"abcd");
        input.filled(4);
        assert!(input.make_space_for(100));
        input.space().copy_from_slice(b"ef");
        input.filled(2);
        assert!(!input.make_space_for(100));
        assert_eq!(input.bytes(), b"abcdef");

        let mut out = OutBuffer::new(Growing::new(2, 4, usize::MAX));
        out.push_bytes(b"ab").unwrap();
        assert_eq!(out.room_max(), 2);
        assert!(!out.make_room(isize::MAX as usize));
        assert_eq!(out.pending(), b"ab");
    }

    #[test]
    fn a_slice_has_what_it_has() {
        let mut bytes = [0; 8];
        let mut out = OutBuffer::new(&mut bytes[..]);
        assert_eq!((out.room_max(), out.capacity_max()), (8, 8));
        assert!(!out.make_room(9));
        out.push_bytes(b"abc").unwrap();
        assert_eq!((out.room_max(), out.make_room(5), out.make_room(6)), (5, true, false));
        out.shrink();
        assert_eq!(out.pending(), b"abc");
        assert!(!(&mut [0u8; 3][..]).grow(4));
    }
}
