// SPDX-License-Identifier: Apache-2.0
//! Whatever bytes a file has, the compiler reads its text with the places that editors show, or reports their encoding.

use std::collections::BTreeMap;

use lf_compiler::characters::{SOURCE_BYTES_MAX, decode};
use lf_compiler::{Compilation, Style, compile};
use proptest::prelude::*;

const PROGRAM: &str = "target Rust\n\n// A reactor.\nimport B from \"b.lf\"\nreactor A {\n  input x: u8\n  \
                       output y: u8\n  reaction(x) -> y {=\n    // é\n    ctx.set(y, 1);\n  =}\n}\n\nmain reactor \
                       {\n  a = new A()\n  b = new B()\n  a.y -> b.z\n}\n";
const IMPORTED: &str = "target Rust\nreactor B {\n  input x: u8\n}\n";

/// Invisible characters, and some that look like others.
const STRANGE: &[char] = &[
    '\u{A0}',
    '\u{200B}',
    '\u{FEFF}',
    '\u{2060}',
    '\u{202E}',
    '\u{3000}',
    '\0',
    '\u{1}',
    '\u{E0041}',
    '“',
    '”',
    '；',
    '–',
];

/// Texts of the program behind tokens.
const PLACES: [&str; 9] =
    ["input", " x: u8", ": u8\n  output", "u8\n  output", "output", " y: u8", "a = new", "= new", "ctx.set"];

fn compiled(main: &[u8], imported: &[u8]) -> Compilation {
    let text = |bytes: &[u8]| decode(bytes.to_vec()).expect("it is UTF-8");
    compile("a.lf", &BTreeMap::from([("a.lf".to_owned(), text(main)), ("b.lf".to_owned(), text(imported))]))
}

/// Returns the messages, without excerpts, whose lines may end otherwise.
fn said(compilation: &Compilation) -> Vec<String> {
    let text = compilation.diagnostics.render(Style::Plain);
    text.lines().filter(|line| line.contains(": error[")).map(str::to_owned).collect()
}

fn written(text: &str, end: &str, has_mark: bool) -> Vec<u8> {
    let mark: &[u8] = if has_mark { b"\xEF\xBB\xBF" } else { b"" };
    [mark, text.replace('\n', end).as_bytes()].concat()
}

proptest! {
    #[test]
    fn marks_and_line_ends_change_no_place(
        ends in prop::array::uniform2(prop::sample::select(vec!["\n", "\r\n", "\r"])),
        marks in prop::array::uniform2(any::<bool>()),
    ) {
        let plain = said(&compiled(PROGRAM.as_bytes(), IMPORTED.as_bytes()));
        prop_assert_eq!(plain.len(), 1, "{:?}", plain);
        let main = written(PROGRAM, ends[0], marks[0]);
        let imported = written(IMPORTED, ends[1], marks[1]);
        prop_assert_eq!(said(&compiled(&main, &imported)), plain);
        // The same program without its error has a plan.
        let right = written(&PROGRAM.replace("b.z", "b.x"), ends[0], marks[0]);
        prop_assert!(compiled(&right, &imported).plan.is_some());
    }

    #[test]
    fn other_encodings_are_named(ends in prop::sample::select(vec!["\n", "\r\n"]), is_little: bool, has_mark: bool) {
        let text = PROGRAM.replace('\n', ends);
        let text = if has_mark { format!("\u{FEFF}{text}") } else { text };
        let order = |bytes: &mut [u8]| if !is_little { bytes.reverse() };
        let mut utf16 = Vec::new();
        for unit in text.encode_utf16() {
            let mut bytes = unit.to_le_bytes();
            order(&mut bytes);
            utf16.extend(bytes);
        }
        let mut utf32 = Vec::new();
        for c in text.chars() {
            let mut bytes = u32::from(c).to_le_bytes();
            order(&mut bytes);
            utf32.extend(bytes);
        }
        prop_assert_eq!(decode(utf16), Err("it is UTF-16 text; save it as UTF-8".to_owned()));
        prop_assert_eq!(decode(utf32), Err("it is UTF-32 text; save it as UTF-8".to_owned()));
    }

    #[test]
    fn a_wrong_byte_has_a_place(line in 1..10_usize, column in 1..20_usize, byte in 0x80..=0xBF_u8) {
        let mut bytes = "\n".repeat(line - 1).into_bytes();
        bytes.extend("é".repeat(column - 1).as_bytes());
        bytes.push(byte);
        let expected =
            format!("it is no UTF-8 text (line {line}, column {column}: byte 0x{byte:02X}); save it as UTF-8");
        prop_assert_eq!(decode(bytes), Err(expected));
    }

    /// The compiler names a meaningless character at any place outside of strings and comments.
    #[test]
    fn a_strange_character_is_named_where_it_is(
        c in prop::sample::select(STRANGE),
        at in 0..9_usize,
    ) {
        let at = PROGRAM.find(PLACES[at]).expect("it is there");
        let text = format!("{}{c}{}", &PROGRAM[..at], &PROGRAM[at..]).replace("b.z", "b.x");
        let compilation = compiled(text.as_bytes(), IMPORTED.as_bytes());
        let number = format!("U+{:04X}", u32::from(c));
        prop_assert!(said(&compilation).iter().any(|line| line.contains(&number)), "{:?}", said(&compilation));
    }
}

#[test]
fn a_file_that_is_too_large_is_not_read() {
    let text = " ".repeat(SOURCE_BYTES_MAX + 1);
    let compilation = compile("a.lf", &BTreeMap::from([("a.lf".to_owned(), text)]));
    assert!(compilation.diagnostics.render(Style::Plain).contains("more than 16 MiB"));
}

#[test]
fn characters_without_meaning_are_one_mistake_however_many_they_are() {
    let text = format!("target Rust\n{}\nmain reactor {{ }}\n", "\0".repeat(1 << 20));
    let compilation = compile("a.lf", &BTreeMap::from([("a.lf".to_owned(), text)]));
    assert_eq!(compilation.diagnostics.counts(), (1, 0), "{}", compilation.diagnostics.render(Style::Plain).len());
}
