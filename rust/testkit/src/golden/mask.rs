// SPDX-License-Identifier: Apache-2.0
//! Bytes of which some vary from run to run.

use std::fmt;
use std::str::FromStr;

/// The bytes of a frame; `None` where they vary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask(Vec<Option<u8>>);

impl Mask {
    /// Returns the bytes; `None` where they vary.
    pub fn bytes(&self) -> &[Option<u8>] {
        &self.0
    }

    /// Returns the number of bytes, masked ones included.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether there are no bytes at all. No recording has such a frame.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the number of masked bytes.
    pub fn masked_len(&self) -> usize {
        self.0.iter().filter(|byte| byte.is_none()).count()
    }

    /// Returns whether these bytes have the right length and are equal wherever nothing is masked.
    pub fn matches(&self, bytes: &[u8]) -> bool {
        self.0.len() == bytes.len() && self.0.iter().zip(bytes).all(|(mask, byte)| mask.is_none_or(|m| m == *byte))
    }

    /// Returns the bytes, if none is masked.
    pub fn exact(&self) -> Option<Vec<u8>> {
        self.0.iter().copied().collect()
    }

    /// Returns the bytes with `values`, in their order, at the masked places.
    ///
    /// # Errors
    /// [`FillError`] if the number of values is not that of the masked bytes.
    pub fn fill(&self, values: &[u8]) -> Result<Vec<u8>, FillError> {
        let masked = self.masked_len();
        if masked != values.len() {
            return Err(FillError { masked, given: values.len() });
        }
        Ok(self.fill_with(values.iter().copied()))
    }

    /// Returns the bytes with the next of `values` at every masked place, and zeros once `values` ends.
    pub fn fill_with(&self, values: impl IntoIterator<Item = u8>) -> Vec<u8> {
        let mut values = values.into_iter();
        self.0.iter().map(|byte| byte.unwrap_or_else(|| values.next().unwrap_or_default())).collect()
    }

    /// Returns the bytes at the masked places, if the others match.
    pub fn extract(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let masked = self.0.iter().zip(bytes).filter(|(mask, _)| mask.is_none()).map(|(_, byte)| *byte);
        self.matches(bytes).then(|| masked.collect())
    }
}

impl fmt::Display for Mask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| match byte {
            Some(byte) => write!(f, "{byte:02x}"),
            None => f.write_str(".."),
        })
    }
}

impl FromStr for Mask {
    type Err = MaskError;

    fn from_str(text: &str) -> Result<Self, MaskError> {
        let byte = |(offset, pair): (usize, &[u8])| match pair {
            b".." => Ok(None),
            [high, low] => digit(*high).zip(digit(*low)).map(|(h, l)| Some(h << 4 | l)).ok_or(MaskError { offset }),
            _ => Err(MaskError { offset }),
        };
        text.as_bytes().chunks(2).enumerate().map(byte).collect::<Result<_, _>>().map(Self)
    }
}

/// Returns the value of a digit in lower case.
fn digit(ascii: u8) -> Option<u8> {
    match ascii {
        b'0'..=b'9' => Some(ascii - b'0'),
        b'a'..=b'f' => Some(ascii - b'a' + 10),
        _ => None,
    }
}

/// A byte that is neither two hexadecimal digits in lower case nor `..`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaskError {
    /// The position of the byte, counted from 0.
    pub offset: usize,
}

impl fmt::Display for MaskError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {} is neither two hexadecimal digits in lower case nor `..`", self.offset)
    }
}

impl std::error::Error for MaskError {}

/// There are more or fewer values than masked bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FillError {
    /// Number of masked bytes.
    pub masked: usize,
    /// Number of values.
    pub given: usize,
}

impl fmt::Display for FillError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes are masked, but {} values were given", self.masked, self.given)
    }
}

impl std::error::Error for FillError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_reads_back_as_it_was_written() {
        for text in ["", "00", "..", "06........00ff", "ff.."] {
            assert_eq!(text.parse::<Mask>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn bad_digits_are_named_by_their_byte() {
        for (text, offset) in [("0", 0), ("000", 1), ("00FF", 1), ("0g", 0), ("00.0", 1), ("0.00", 0), ("é0", 0)] {
            assert_eq!(text.parse::<Mask>(), Err(MaskError { offset }), "{text}");
        }
    }

    #[test]
    fn masked_bytes_match_anything_and_are_filled_in_order() {
        let mask: Mask = "06..00..".parse().unwrap();
        assert!(mask.matches(&[6, 1, 0, 2]) && !mask.matches(&[6, 1, 1, 2]) && !mask.matches(&[6, 1, 0]));
        assert_eq!(mask.fill(&[9, 8]), Ok(vec![6, 9, 0, 8]));
        assert_eq!(mask.fill(&[9]), Err(FillError { masked: 2, given: 1 }));
        assert_eq!(mask.extract(&[6, 9, 0, 8]), Some(vec![9, 8]));
        assert_eq!(mask.extract(&[7, 9, 0, 8]), None);
        assert_eq!(mask.exact(), None);
        assert_eq!("0600".parse::<Mask>().unwrap().exact(), Some(vec![6, 0]));
    }
}
