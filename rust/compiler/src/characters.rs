// SPDX-License-Identifier: Apache-2.0
//! Characters of source texts: decoding, and characters that are invisible or look like others.

use std::borrow::Cow;

/// The maximum size of a source file in bytes: far more than any hand-written file has, and little enough for memory.
pub const SOURCE_BYTES_MAX: usize = 16 << 20;

/// Refuses a file that is too large; the reason is the end of a sentence: `it has …`.
///
/// # Errors
/// When it is too large.
pub fn check_size(bytes: u64) -> Result<(), String> {
    if bytes > SOURCE_BYTES_MAX as u64 {
        return Err(format!("it has more than {} MiB, which no program needs", SOURCE_BYTES_MAX >> 20));
    }
    Ok(())
}

/// Returns the text of a file.
///
/// # Errors
/// Returns the reason why its bytes are no text, as the end of a sentence: `it is UTF-16 …`.
pub fn decode(bytes: Vec<u8>) -> Result<String, String> {
    check_size(bytes.len() as u64)?;
    // The byte order marks of UTF-32 begin like those of UTF-16.
    let other = match &bytes[..] {
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] => Some("UTF-32"),
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("UTF-16"),
        [0, 0, 0, first, ..] | [first, 0, 0, 0, ..] if first.is_ascii_graphic() => Some("UTF-32"),
        [0, first, 0, _, ..] | [first, 0, _, 0, ..] if first.is_ascii_graphic() => Some("UTF-16"),
        _ => None,
    };
    if let Some(encoding) = other {
        return Err(format!("it is {encoding} text; save it as UTF-8"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (at, bytes) = (error.utf8_error().valid_up_to(), error.as_bytes());
        let before = String::from_utf8_lossy(&bytes[..at]);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let byte = bytes.get(at).copied().unwrap_or_default();
        format!("it is no UTF-8 text (line {line}, column {column}: byte 0x{byte:02X}); save it as UTF-8")
    })
}

/// Returns a text without the additions of some editors: the byte order mark at its beginning, and carriage returns
/// that end lines by themselves, which become line feeds. All other bytes stay as they are, so places are those that
/// editors show.
pub(crate) fn cleaned(text: &str) -> Cow<'_, str> {
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let ends_line = |(at, _): &(usize, &str)| text.as_bytes().get(at + 1) != Some(&b'\n');
    if !text.match_indices('\r').any(|found| ends_line(&found)) {
        return Cow::Borrowed(text);
    }
    let mut cleaned = String::with_capacity(text.len());
    let mut done = 0;
    for (at, _) in text.match_indices('\r').filter(ends_line) {
        cleaned = cleaned + &text[done..at] + "\n";
        done = at + 1;
    }
    Cow::Owned(cleaned + &text[done..])
}

/// Names of invisible characters, as Unicode has them.
const INVISIBLE: &[(char, &str)] = &[
    ('\0', "null character"),
    ('\u{85}', "next line"),
    ('\u{A0}', "no-break space"),
    ('\u{AD}', "soft hyphen"),
    ('\u{61C}', "Arabic letter mark"),
    ('\u{180E}', "Mongolian vowel separator"),
    ('\u{200B}', "zero width space"),
    ('\u{200C}', "zero width non-joiner"),
    ('\u{200D}', "zero width joiner"),
    ('\u{200E}', "left-to-right mark"),
    ('\u{200F}', "right-to-left mark"),
    ('\u{2028}', "line separator"),
    ('\u{2029}', "paragraph separator"),
    ('\u{202A}', "left-to-right embedding"),
    ('\u{202B}', "right-to-left embedding"),
    ('\u{202C}', "pop directional formatting"),
    ('\u{202D}', "left-to-right override"),
    ('\u{202E}', "right-to-left override"),
    ('\u{202F}', "narrow no-break space"),
    ('\u{2060}', "word joiner"),
    ('\u{2066}', "left-to-right isolate"),
    ('\u{2067}', "right-to-left isolate"),
    ('\u{2068}', "first strong isolate"),
    ('\u{2069}', "pop directional isolate"),
    ('\u{3000}', "ideographic space"),
    ('\u{FEFF}', "byte order mark"),
];

/// Characters that look like one of ASCII, with that one.
const ALIKE: &[(&str, &str)] = &[
    ("“”„‟″", "\""),
    ("‘’‚‛′", "'"),
    ("‐‑‒–—―−", "-"),
    ("\u{37E}⁏", ";"),
    ("×∗⋅", "*"),
    ("…", "..."),
    ("→", "->"),
    ("∕⁄", "/"),
];

/// Returns whether a character outside of ASCII's own blanks is invisible.
pub(crate) fn is_invisible(c: char) -> bool {
    match c {
        '\t' | '\n' | '\r' | '\x0C' | ' ' => false,
        '\u{AD}'
        | '\u{34F}'
        | '\u{61C}'
        | '\u{115F}'
        | '\u{1160}'
        | '\u{17B4}'
        | '\u{17B5}'
        | '\u{3164}'
        | '\u{180B}'..='\u{180F}'
        | '\u{200B}'..='\u{200F}'
        | '\u{202A}'..='\u{202E}'
        | '\u{2060}'..='\u{206F}'
        | '\u{FE00}'..='\u{FE0F}'
        | '\u{FEFF}'
        | '\u{FFA0}'
        | '\u{FFF0}'..='\u{FFFB}'
        | '\u{1D173}'..='\u{1D17A}'
        | '\u{E0000}'..='\u{E0FFF}'
        // For unassigned characters, fonts show nothing, or a box.
        | '\u{E000}'..='\u{F8FF}'
        | '\u{F0000}'..='\u{10FFFF}' => true,
        _ => c.is_control() || c.is_whitespace(),
    }
}

/// Returns whether a character changes the direction of the text around it, so that the text looks different from its
/// order.
pub(crate) fn is_directing(c: char) -> bool {
    matches!(c, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

/// Returns a character as messages show it: outside of ASCII with its number, and by its name if it is invisible.
pub(crate) fn shown(c: char) -> String {
    let number = format!("U+{:04X}", u32::from(c));
    match INVISIBLE.iter().find(|(known, _)| *known == c) {
        Some((_, name)) => format!("{number} ({name})"),
        None if is_invisible(c) => format!("{number} (an invisible character)"),
        None if c.is_ascii() => format!("`{c}`"),
        None => format!("`{c}` ({number})"),
    }
}

/// Returns the replacement for a character that has no meaning.
pub(crate) fn instead(c: char) -> Option<String> {
    if is_invisible(c) {
        let blank = c.is_whitespace() && !c.is_control();
        return Some(if blank { "write an ordinary space in its place" } else { "remove it" }.to_owned());
    }
    let wide = matches!(c, '\u{FF01}'..='\u{FF5E}').then(|| char::from_u32(u32::from(c) - 0xFEE0)).flatten();
    let alike = ALIKE.iter().find(|(all, _)| all.contains(c)).map(|(_, ascii)| (*ascii).to_owned());
    alike.or(wide.map(String::from)).map(|ascii| format!("did you mean `{ascii}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invisible_characters_have_a_number_and_a_name() {
        assert_eq!(shown('\u{A0}'), "U+00A0 (no-break space)");
        assert_eq!(shown('\u{E0041}'), "U+E0041 (an invisible character)");
        assert_eq!(shown('“'), "`“` (U+201C)");
        assert_eq!(instead('；').as_deref(), Some("did you mean `;`?"));
        assert_eq!(instead('\u{200B}').as_deref(), Some("remove it"));
        assert!(INVISIBLE.iter().all(|(c, _)| is_invisible(*c)));
    }

    #[test]
    fn marks_and_single_carriage_returns_are_taken_away() {
        assert_eq!(cleaned("\u{FEFF}a\rb\r\nc\r"), "a\nb\r\nc\n");
        assert_eq!(cleaned("a\u{FEFF}"), "a\u{FEFF}");
    }
}
