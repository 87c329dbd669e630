// SPDX-License-Identifier: Apache-2.0
//! Texts in pictures: their widths, which depend on the reader's fonts, and their characters in XML.

use std::fmt;

/// The size of names, in pixels.
pub(super) const NAME_SIZE: i64 = 13;
/// The size of everything else.
pub(super) const SMALL_SIZE: i64 = 11;

/// Returns the greatest width of a text in fonts without serifs that computers usually have.
pub(super) fn width(text: &str, size: i64) -> i64 {
    // In thousandths of the size, for DejaVu Sans, the widest of these fonts.
    let of = |character: char| match character {
        'i' | 'j' | 'l' | '\'' | '|' => 340,
        ' ' | '.' | ',' | ':' | ';' | 'I' => 350,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' | '!' => 420,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 1000,
        'A'..='Z' => 770,
        character if character.is_ascii() => 640,
        _ => 1000,
    };
    (text.chars().map(of).sum::<i64>() * size).div_euclid(1000) + 1
}

/// A text between tags or in quotation marks.
pub(super) struct Escaped<'a>(pub(super) &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                // XML has no other control characters, however they are written.
                '\t' | '\n' | '\r' => f.write_str(" ")?,
                '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => f.write_str("\u{fffd}")?,
                _ => write!(f, "{character}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Escaped, width};

    #[test]
    fn texts_are_xml_whatever_is_in_them() {
        assert_eq!(Escaped("a<b> & \"c\"\n\u{1}").to_string(), "a&lt;b&gt; &amp; &quot;c&quot; \u{fffd}");
    }

    #[test]
    fn longer_texts_are_wider() {
        assert!(
            width("", 13) < width("i", 13) && width("i", 13) < width("ii", 13) && width("ii", 11) < width("MM", 11)
        );
    }
}
