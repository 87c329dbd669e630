// SPDX-License-Identifier: Apache-2.0
//! The layouts of values in messages, independent of languages.

use core::fmt;

use serde::{Deserialize, Serialize};

/// The layout of a value in a message, as far as one language can describe it to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// No values.
    Nothing,
    /// One byte, 0 or 1.
    Bool,
    /// One byte, with unknown sign.
    Byte,
    /// An unsigned integer of this number of bytes.
    Unsigned(u8),
    /// A signed integer of this number of bytes.
    Signed(u8),
    /// A floating-point number of this number of bytes.
    Float(u8),
    /// A text that ends with a zero.
    Text,
    /// A variable number of elements.
    List(Box<Shape>),
    /// A fixed number of elements.
    Array(Box<Shape>, u64),
    /// Fields with their names, laid out as C does it.
    Struct(Vec<(String, Shape)>),
    /// A type that only its language's own compiler knows by this name.
    Named(String),
}

impl Shape {
    /// Returns whether values of the one can be read as values of the other, as far as both are known.
    pub(crate) fn fits(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Named(_), Self::Nothing | Self::Text | Self::List(_))
            | (Self::Nothing | Self::Text | Self::List(_), Self::Named(_)) => false,
            (Self::Named(_), _)
            | (_, Self::Named(_))
            | (Self::Byte, Self::Unsigned(1) | Self::Signed(1))
            | (Self::Unsigned(1) | Self::Signed(1), Self::Byte) => true,
            (Self::List(one), Self::List(other)) => one.fits(other),
            (Self::Array(one, length), Self::Array(other, same)) => length == same && one.fits(other),
            (Self::Struct(fields), Self::Struct(others)) => {
                fields.len() == others.len()
                    && fields.iter().zip(others).all(|((name, one), (same, other))| name == same && one.fits(other))
            }
            (one, other) => one == other,
        }
    }

    /// Returns the number of bytes of a value; `None` if it varies, or is unknown.
    pub(crate) fn size(&self) -> Option<u64> {
        self.layout().map(|(size, _)| size)
    }

    /// Returns the size and the alignment of a value.
    fn layout(&self) -> Option<(u64, u64)> {
        match self {
            Self::Nothing => Some((0, 1)),
            Self::Bool | Self::Byte => Some((1, 1)),
            Self::Unsigned(bytes) | Self::Signed(bytes) | Self::Float(bytes) => {
                Some((u64::from(*bytes), u64::from(*bytes)))
            }
            Self::Array(inner, length) => {
                let (size, align) = inner.layout()?;
                Some((size.checked_mul(*length)?, align))
            }
            Self::Struct(fields) => {
                let widest = fields.iter().filter_map(|(_, field)| Some(field.layout()?.1)).max().unwrap_or(1);
                Some((end_of(fields)?.checked_next_multiple_of(widest)?, widest))
            }
            Self::Text | Self::List(_) | Self::Named(_) => None,
        }
    }

    /// Returns the offset of a struct's last field.
    pub(crate) fn offset_of_last(&self) -> Option<u64> {
        let Self::Struct(fields) = self else { return None };
        let ((_, last), before) = fields.split_last()?;
        end_of(before)?.checked_next_multiple_of(last.layout()?.1)
    }

    /// Returns whether there is a part that is known by its name only.
    pub(crate) fn has_names(&self) -> bool {
        match self {
            Self::Named(_) => true,
            Self::List(inner) | Self::Array(inner, _) => inner.has_names(),
            Self::Struct(fields) => fields.iter().any(|(_, field)| field.has_names()),
            _ => false,
        }
    }
}

/// Returns the end of the last of some fields.
fn end_of(fields: &[(String, Shape)]) -> Option<u64> {
    fields.iter().try_fold(0_u64, |end, (_, field)| {
        let (size, align) = field.layout()?;
        end.checked_next_multiple_of(align)?.checked_add(size)
    })
}

/// A description for messages.
impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("no value"),
            Self::Bool => f.write_str("a boolean"),
            Self::Byte => f.write_str("a byte"),
            Self::Unsigned(bytes) => write!(f, "an unsigned integer of {} bits", 8 * bytes),
            Self::Signed(bytes) => write!(f, "a signed integer of {} bits", 8 * bytes),
            Self::Float(bytes) => write!(f, "a floating-point number of {} bits", 8 * bytes),
            Self::Text => f.write_str("a text"),
            Self::List(inner) => write!(f, "a list, and each element is {inner}"),
            Self::Array(inner, length) => write!(f, "an array of {length}, and each element is {inner}"),
            Self::Struct(_) => f.write_str("a struct"),
            Self::Named(_) => f.write_str("a type that its own compiler knows"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Shape::{self, Array, Bool, Byte, Float, List, Named, Nothing, Signed, Struct, Text, Unsigned};

    fn point(x: Shape) -> Shape {
        Struct(vec![("x".to_owned(), x), ("y".to_owned(), Float(8))])
    }

    #[test]
    fn values_are_read_as_they_were_written() {
        let list = |of: Shape| List(Box::new(of));
        let same = [
            (Signed(4), Signed(4)),
            (Byte, Unsigned(1)),
            (Signed(1), Byte),
            (Text, Text),
            (list(Byte), list(Unsigned(1))),
            (point(Signed(4)), point(Signed(4))),
            (Named("point_t".to_owned()), point(Bool)),
            (list(point(Bool)), list(Named("point_t".to_owned()))),
        ];
        let different = [
            (Signed(4), Unsigned(4)),
            (Float(4), Float(8)),
            (Bool, Unsigned(1)),
            (Text, list(Byte)),
            (Nothing, Bool),
            (Named("text_t".to_owned()), Text),
            (Array(Box::new(Byte), 3), Array(Box::new(Byte), 4)),
            (point(Signed(4)), point(Float(4))),
        ];
        for (one, other) in same {
            assert!(one.fits(&other) && other.fits(&one), "{one:?} and {other:?}");
        }
        for (one, other) in different {
            assert!(!one.fits(&other) && !other.fits(&one), "{one:?} and {other:?}");
        }
    }
}
