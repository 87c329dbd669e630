// SPDX-License-Identifier: Apache-2.0
//! Texts and lists without a bound in their type, which a `@max_length(n)` before a port allows to be sent.

use lf_model::layout::Field;
use lf_model::{PayloadError, Serializer, list_from, list_to, text_from, text_to};

/// At most `N` bytes of a `String`, or elements of a `Vec`. The bytes are those of `heapless::String<N>` and
/// `heapless::Vec<T, N>`.
#[derive(Clone, Copy, Debug)]
pub struct MaxLength<const N: usize>;

impl<const N: usize> Serializer<String> for MaxLength<N> {
    const MAX_LEN: usize = N + 1;

    fn encode(value: &String, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        text_to(value, N, bytes)
    }

    fn decode(bytes: &[u8]) -> Result<String, PayloadError> {
        let text = text_from(bytes)?;
        if text.len() > N {
            return Err(PayloadError::TooLong { capacity: N, found: text.len() });
        }
        Ok(text.to_owned())
    }
}

impl<T: Field, const N: usize> Serializer<Vec<T>> for MaxLength<N> {
    const MAX_LEN: usize = <heapless::Vec<T, N> as lf_model::Payload>::MAX_LEN;

    fn encode(value: &Vec<T>, bytes: &mut [u8]) -> Result<usize, PayloadError> {
        list_to(value, N, bytes)
    }

    fn decode(bytes: &[u8]) -> Result<Vec<T>, PayloadError> {
        list_from(bytes, N)
    }
}

#[cfg(test)]
mod tests {
    use lf_model::{Payload, PayloadError, Serializer};

    use super::MaxLength;

    #[test]
    fn texts_and_lists_have_the_bytes_of_heapless_ones() {
        let (mut bytes, mut same) = ([0; 16], [0; 16]);
        let text = heapless::String::<5>::try_from("abcde").expect("it fits");
        let len = MaxLength::<5>::encode(&"abcde".to_owned(), &mut bytes).expect("it fits");
        let same_len = text.encode(&mut same).expect("it fits");
        assert_eq!(bytes[..len], same[..same_len]);
        let decoded: Result<String, _> = MaxLength::<5>::decode(&bytes[..len]);
        assert_eq!(decoded.as_deref(), Ok("abcde"));
        let len = MaxLength::<3>::encode(&vec![1u16, 2, 3], &mut bytes).expect("it fits");
        assert_eq!(bytes[..len], [1, 0, 2, 0, 3, 0]);
        assert_eq!(MaxLength::<3>::decode(&bytes[..len]), Ok(vec![1u16, 2, 3]));
    }

    #[test]
    fn more_than_the_bound_is_neither_sent_nor_received() {
        let mut bytes = [0; 16];
        let text = PayloadError::TooLong { capacity: 2, found: 3 };
        assert_eq!(MaxLength::<2>::encode(&"abc".to_owned(), &mut bytes), Err(text));
        assert_eq!(<MaxLength<2> as Serializer<String>>::decode(b"abc\0"), Err(text));
        assert_eq!(MaxLength::<2>::encode(&vec![1u16, 2, 3], &mut bytes), Err(text));
        assert_eq!(<MaxLength<2> as Serializer<Vec<u16>>>::decode(&[0; 6]), Err(text));
    }
}
