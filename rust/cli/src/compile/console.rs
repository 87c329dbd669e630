// SPDX-License-Identifier: Apache-2.0
//! Converts places in generated files within an image's output, such as that of a panic, to places in the program.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use lf_compiler::emit::SourceMap;

use super::stored;
use crate::failure::Failure;

/// The text between a file's name and a line in a position of Rust.
const MARK: &str = ".rs:";

/// The code of an image, for its console.
#[derive(Debug)]
pub(crate) struct Console {
    /// The folder of the generated crate.
    folder: PathBuf,
    map: SourceMap,
}

impl Console {
    /// Returns the code of a generated crate; `None` for other crates.
    ///
    /// # Errors
    /// When the files beside the crate cannot be read.
    pub(crate) fn of(folder: &Path) -> Result<Option<Self>, Failure> {
        let map = stored::map(folder)?;
        Ok(map.map(|map| Self { folder: folder.to_owned(), map }))
    }

    /// Returns the code of a generated crate, which has to exist.
    ///
    /// # Errors
    /// When there is none, or it cannot be read.
    pub(crate) fn known(folder: &Path) -> Result<Self, Failure> {
        let missing = || io::Error::other(format!("{} is no folder of a generated crate", folder.display()));
        Ok(Self::of(folder)?.ok_or_else(missing)?)
    }

    /// Returns a line with places in the program instead of those in generated files.
    pub(crate) fn with_lf_places<'l>(&self, line: &'l [u8]) -> Cow<'l, [u8]> {
        let Ok(mut rest) = str::from_utf8(line) else { return Cow::Borrowed(line) };
        let mut text = String::new();
        while let Some(mark) = rest.find(MARK) {
            let behind = mark + MARK.len();
            let start = rest[..mark].rfind(|sign: char| sign.is_whitespace() || "'\"(`".contains(sign));
            let start = start.map_or(0, |at| at + rest[at..].chars().next().map_or(1, char::len_utf8));
            if let Some((place, length)) = self.place(&rest[start..behind - 1], &rest[behind..]) {
                text = text + &rest[..start] + &place;
                rest = &rest[behind + length..];
            } else {
                text += &rest[..behind];
                rest = &rest[behind..];
            }
        }
        if text.is_empty() { Cow::Borrowed(line) } else { Cow::Owned((text + rest).into_bytes()) }
    }

    /// Returns the place in the program for `src/p.rs` and `12:5…`, and the length of the latter that belongs to it.
    fn place(&self, file: &str, numbers: &str) -> Option<(String, usize)> {
        let digits = |text: &str| text.find(|sign: char| !sign.is_ascii_digit()).unwrap_or(text.len());
        let line_end = digits(numbers);
        let column = numbers[line_end..].strip_prefix(':')?;
        let column_end = digits(column);
        let file = Path::new(file);
        let file = file.strip_prefix(&self.folder).unwrap_or(file).to_str()?;
        let (line, column) = (numbers[..line_end].parse().ok()?, column[..column_end].parse().ok()?);
        let (lf, lf_line, lf_column) = self.map.to_lf(file, line, column)?;
        Some((format!("{lf}:{lf_line}:{lf_column}"), line_end + 1 + column_end))
    }
}
