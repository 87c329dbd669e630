// SPDX-License-Identifier: Apache-2.0
//! The generated crates of a program as tools read them: with the bodies of the editor, whatever is wrong in these, and
//! with the way from each place there to the LF file and back.
//!
//! A body that is being typed is no Rust, and a program with such a body has no plan. So the compiler sees a comment of
//! the same lines and columns in its place, and the body itself is put in where the comment has come out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lf_compiler::emit::SourceMap;
use lf_compiler::syntax::{LexemeKind, lexemes};
use lf_compiler::{Compilation, Diagnostics, Severity, SourceProvider as _, compile};
use lsp_types::{Position, Range};

use super::parts::{CodePart, parts_of_c};
use crate::compile::ReadableCode;
use crate::lsp::buffers::Buffers;

/// The generated crates of a program.
pub(super) struct CodeProject {
    code: ReadableCode,
    /// The generated files, by their paths in the folder.
    texts: BTreeMap<String, String>,
    /// The texts of the program's files, by their paths.
    lf_texts: BTreeMap<String, String>,
    /// The parts that are verbatim in both, by generated file and place.
    parts: Vec<CodePart>,
}

/// A place in a generated file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct GeneratedPlace {
    pub(super) file: String,
    pub(super) position: Position,
    /// Whether it is exactly the place asked, and not the last one before blanks.
    pub(super) is_exact: bool,
}

impl CodeProject {
    /// Returns the crates of the program whose main file is at a path, unless it has errors outside of bodies.
    pub(super) fn new(buffers: &Buffers, main: &str) -> Option<Self> {
        let Compilation { plan, diagnostics } = compile(main, buffers);
        let plan = match plan {
            Some(plan) => plan,
            None => compile(main, &with_masks(buffers, &diagnostics)).plan?,
        };
        let code = ReadableCode::new(Path::new(main), &plan).ok()?;
        let lf_texts: BTreeMap<String, String> =
            plan.files.iter().filter_map(|file| Some((file.path.clone(), buffers.read(&file.path).ok()?))).collect();
        let mut texts: BTreeMap<String, String> =
            code.emitted.files.iter().map(|file| (file.path.clone(), file.text.clone())).collect();
        let mut parts: Vec<CodePart> = code.emitted.source_map.verbatim().map(CodePart::from).collect();
        unmask(&mut texts, &parts, &lf_texts);
        for (path, text) in &texts {
            parts.extend(parts_of_c(path, text, &lf_texts));
        }
        Some(Self { code, texts, lf_texts, parts })
    }

    /// Returns the folder of the crates.
    pub(super) fn folder(&self) -> &Path {
        &self.code.folder
    }

    /// Returns whether a file is part of the program.
    pub(super) fn has(&self, lf_path: &str) -> bool {
        self.lf_texts.contains_key(lf_path)
    }

    /// Returns whether the program is the one of these texts.
    pub(super) fn is_of(&self, buffers: &Buffers) -> bool {
        self.lf_texts.iter().all(|(path, text)| buffers.read(path).as_ref() == Ok(text))
    }

    /// Returns the text of a generated file.
    pub(super) fn text(&self, file: &str) -> Option<&str> {
        self.texts.get(file).map(String::as_str)
    }

    /// Writes the crates to their folder, for what the tools read by themselves.
    pub(super) fn write(&self) -> std::io::Result<()> {
        self.code.write(self.texts.iter().map(|(path, text)| (path.as_str(), text.as_str())))
    }

    /// Returns the path of a file in the folder.
    pub(super) fn inside(&self, path: &Path) -> Option<String> {
        let inside: PathBuf = path.strip_prefix(self.folder()).ok()?.to_owned();
        inside.to_str().map(str::to_owned)
    }

    /// Returns the place in generated code for a place in a code block of an LF file; of several copies the first one.
    pub(super) fn to_generated(&self, lf_path: &str, position: Position) -> Option<GeneratedPlace> {
        let text = self.lf_texts.get(lf_path)?;
        let (line, column) = characters(text, position);
        let holds = |part: &&CodePart| part.lf == lf_path && part.lf_line == line && part.holds_lf(column);
        let here =
            self.parts.iter().filter(holds).max_by_key(|part| (part.lf_column, std::cmp::Reverse(&part.generated)));
        if let Some(part) = here {
            let position = self.position(part, column - part.lf_column)?;
            return Some(GeneratedPlace { file: part.generated.clone(), position, is_exact: true });
        }
        // Blanks at the end of a body are not generated: code there follows what is before them.
        let is_before =
            |part: &&CodePart| part.lf == lf_path && (part.lf_line, part.lf_column + part.len) < (line, column);
        let last = |part: &&CodePart| (part.lf_line, part.lf_column, std::cmp::Reverse(part.generated.clone()));
        let part = self.parts.iter().filter(is_before).max_by_key(last)?;
        let (from, to) = (offset(text, part.lf_line, part.lf_column + part.len), offset(text, line, column));
        let are_blanks = text.get(from..to).is_some_and(|between| between.trim().is_empty());
        let position = self.position(part, part.len).filter(|_| are_blanks)?;
        Some(GeneratedPlace { file: part.generated.clone(), position, is_exact: false })
    }

    /// Returns the place in generated code that is a number of characters behind the beginning of a part.
    fn position(&self, part: &CodePart, behind: usize) -> Option<Position> {
        Some(utf16(self.texts.get(&part.generated)?, part.line, part.column + behind))
    }

    /// Returns the LF file and the range there that a range of generated code is.
    pub(super) fn to_lf(&self, file: &str, range: Range) -> Option<(&str, Range)> {
        let (start, end) = (self.lf_place(file, range.start)?, self.lf_place(file, range.end)?);
        (start.0 == end.0).then(|| (start.0, Range::new(start.1, end.1)))
    }

    fn lf_place(&self, file: &str, position: Position) -> Option<(&str, Position)> {
        let (line, column) = characters(self.texts.get(file)?, position);
        let holds = |part: &&CodePart| part.generated == file && part.line == line && part.holds_generated(column);
        let part = self.parts.iter().filter(holds).max_by_key(|part| part.column)?;
        let text = self.lf_texts.get(&part.lf)?;
        Some((&part.lf, utf16(text, part.lf_line, part.lf_column + column - part.column)))
    }

    /// Returns the LF file and the place there of what stands at a range of generated code, or of the declaration for
    /// which that was generated.
    pub(super) fn origin(&self, file: &str, range: Range) -> Option<(&str, Range)> {
        self.to_lf(file, range).or_else(|| {
            let (line, column) = characters(self.texts.get(file)?, range.start);
            let map: &SourceMap = &self.code.emitted.source_map;
            let (path, line, column) = map.to_lf(file, line, column)?;
            let (path, text) = self.lf_texts.get_key_value(path)?;
            let position = utf16(text, line, column);
            Some((path, Range::new(position, position)))
        })
    }
}

/// Returns the texts with comments in the place of the code blocks that have errors.
fn with_masks(buffers: &Buffers, diagnostics: &Diagnostics) -> Buffers {
    let mut masked = buffers.clone();
    let mut texts: BTreeMap<&str, String> = BTreeMap::new();
    for error in diagnostics.iter().filter(|one| one.severity() == Severity::Error) {
        let Some(source) = diagnostics.sources().get(error.span.file) else { continue };
        let text = texts.entry(source.path()).or_insert_with(|| source.text().to_owned());
        let all = lexemes(source.text());
        let is_it = |start: usize, end: usize| start <= error.span.start && error.span.start <= end;
        let block = all.iter().find(|one| one.kind == LexemeKind::Code && is_it(one.start, one.end));
        let inside = block.and_then(|block| source.text().get(block.start + 2..block.end.saturating_sub(2)));
        // The number of characters stays, the number of bytes need not: so what is replaced is looked for.
        if let Some(inside) = inside
            && let Some(mask) = mask(inside)
        {
            *text = text.replacen(&format!("{{={inside}=}}"), &format!("{{={mask}=}}"), 1);
        }
    }
    for (path, text) in texts {
        masked.replace(path, text);
    }
    masked
}

/// Returns a comment with the lines and the lengths of code.
fn mask(code: &str) -> Option<String> {
    let mut characters: Vec<char> = code.chars().collect();
    let is_pair = |pair: &[char]| !pair.contains(&'\n');
    let begin = characters.windows(2).position(is_pair)?;
    let end = characters.windows(2).rposition(is_pair).filter(|end| *end > begin + 1)?;
    for (index, character) in characters.iter_mut().enumerate().filter(|(_, character)| **character != '\n') {
        *character = match index {
            _ if index == begin => '/',
            _ if index == begin + 1 || index == end => '*',
            _ if index == end + 1 => '/',
            _ if index < begin || index > end => ' ',
            _ => 'x',
        };
    }
    Some(characters.into_iter().collect())
}

/// Puts the program's text into all verbatim parts.
fn unmask(texts: &mut BTreeMap<String, String>, parts: &[CodePart], lf_texts: &BTreeMap<String, String>) {
    let lines: BTreeMap<&str, Vec<&str>> =
        lf_texts.iter().map(|(path, text)| (path.as_str(), text.split('\n').collect())).collect();
    for (path, text) in texts {
        let mut own = parts.iter().filter(|part| part.generated == *path).peekable();
        if own.peek().is_none() {
            continue;
        }
        let mut generated: Vec<String> = text.split('\n').map(str::to_owned).collect();
        for part in own {
            let Some(line) = generated.get_mut(part.line - 1) else { continue };
            let Some(lf) = lines.get(part.lf.as_str()).and_then(|lines| lines.get(part.lf_line - 1)) else { continue };
            let own: String = lf.chars().skip(part.lf_column - 1).take(part.len).collect();
            let there: String = line.chars().skip(part.column - 1).take(part.len).collect();
            if own != there {
                let before: String = line.chars().take(part.column - 1).collect();
                let after: String = line.chars().skip(part.column - 1 + part.len).collect();
                *line = before + &own + &after;
            }
        }
        *text = generated.join("\n");
    }
}

/// Returns the line and the column of a place as the compiler counts them: from 1, in characters.
fn characters(text: &str, position: Position) -> (usize, usize) {
    let number = |count: u32| usize::try_from(count).unwrap_or(usize::MAX);
    let line = text.split('\n').nth(number(position.line)).unwrap_or_default();
    let mut units = 0;
    let before = line.chars().take_while(|character| {
        units += character.len_utf16();
        units <= number(position.character)
    });
    (number(position.line).saturating_add(1), before.count() + 1)
}

/// Returns a place as the protocol counts it.
fn utf16(text: &str, line: usize, column: usize) -> Position {
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let text = text.split('\n').nth(line - 1).unwrap_or_default();
    let units: usize = text.chars().take(column - 1).map(char::len_utf16).sum();
    Position::new(number(line - 1), number(units))
}

/// Returns the byte of a place.
fn offset(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
    let rest = text.get(start..).unwrap_or_default();
    start + rest.chars().take(column - 1).map(char::len_utf8).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::mask;

    #[test]
    fn a_mask_is_a_comment_with_the_places_of_the_code() {
        assert_eq!(mask(" ctx. ").as_deref(), Some("/*xx*/"));
        assert_eq!(mask("\n  let = \"ü\";\n  ").as_deref(), Some("\n/*xxxxxxxxxx\n*/"));
        assert_eq!(mask("\n.\n  self.\n}\n").as_deref(), Some("\n \n/*xxx*/\n \n"));
        assert_eq!(mask(" . "), None);
    }
}
