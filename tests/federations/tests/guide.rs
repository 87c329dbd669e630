// SPDX-License-Identifier: Apache-2.0
//! The programs in the README and in the guide: each block `lf` is a whole program that compiles without a warning, and
//! if a block `output` follows before the next one, running the program prints exactly that.

use std::fs;
use std::path::{Path, PathBuf};

use lf_federations::{Lfz, Run, TIME_LIMIT, is_of_build};

/// A program in a document, and files that it needs.
struct Listing {
    /// The document and the number of the listing in it: `language_2`.
    name: String,
    /// The program, as it stands there.
    program: String,
    /// The files before it, each with its path as the second word behind the fence, and its text.
    files: Vec<(String, String)>,
    /// The file among them that sets the inputs of devices: its fence says `devices`.
    script: Option<String>,
    /// The expected output, if it follows.
    output: Option<Vec<String>>,
}

/// Returns the blocks of code in a document: the text behind the fence, and the lines.
fn blocks(text: &str) -> Vec<(&str, Vec<&str>)> {
    let (mut blocks, mut is_open) = (Vec::<(&str, Vec<&str>)>::new(), false);
    for line in text.lines() {
        if let Some(kind) = line.strip_prefix("```") {
            is_open = !is_open;
            if is_open {
                blocks.push((kind, Vec::new()));
            }
        } else if let Some((_, lines)) = blocks.last_mut().filter(|_| is_open) {
            lines.push(line);
        }
    }
    blocks
}

/// Returns all programs of the documents.
fn listings() -> Vec<Listing> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let chapters = fs::read_dir(repository.join("docs/guide/src")).expect("the guide is part of the repository");
    let mut documents: Vec<PathBuf> = chapters.map(|entry| entry.expect("the folder can be listed").path()).collect();
    documents.push(repository.join("README.md"));
    documents.sort();
    let mut listings = Vec::<Listing>::new();
    for document in documents.iter().filter(|path| path.extension().is_some_and(|kind| kind == "md")) {
        let stem = document.file_stem().expect("it has a name").to_string_lossy().replace('-', "_").to_lowercase();
        let text = fs::read_to_string(document).expect("the document can be read");
        let first = listings.len();
        let (mut files, mut script) = (Vec::new(), None);
        for (kind, lines) in blocks(&text) {
            if kind == "lf" {
                let name = format!("{stem}_{}", listings.len() - first + 1);
                let files = std::mem::take(&mut files);
                listings.push(Listing { name, program: lines.join("\n"), files, script: script.take(), output: None });
            } else if let Some((language, path)) = kind.split_once(' ') {
                script = (language == "devices").then(|| path.to_owned()).or(script);
                files.push((path.to_owned(), lines.join("\n") + "\n"));
            } else if kind == "output" {
                let listing = listings[first..].last_mut().expect("a program comes before its output");
                let said = listing.output.replace(lines.into_iter().map(str::to_owned).collect());
                assert!(said.is_none(), "{} has two outputs", listing.name);
            }
        }
    }
    assert!(listings.len() > 10, "only {} listings were found", listings.len());
    listings
}

/// Writes a program and its files into a folder.
fn write(folder: &Path, listing: &Listing) -> PathBuf {
    for (path, text) in &listing.files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("it lies in the folder")).expect("there is room for a folder");
        fs::write(path, text).expect("there is room for a file");
    }
    let file = folder.join(format!("{}.lf", listing.name));
    fs::write(&file, &listing.program).expect("there is room for a file");
    file
}

#[test]
fn every_program_in_the_documents_compiles_without_a_warning() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    for listing in listings() {
        let mut command = Lfz::command(["check"]);
        command.arg(write(folder.path(), &listing));
        let finished = Run::start(command).finish();
        assert_eq!(finished.code(), 0, "{}: {finished}", listing.name);
        assert!(!finished.lines.iter().any(|line| line.starts_with("warning")), "{}: {finished}", listing.name);
    }
}

#[test]
fn programs_in_the_documents_print_what_stands_behind_them() {
    let folder = tempfile::tempdir().expect("there is room for a folder");
    let runs = listings().into_iter().filter_map(|listing| {
        let output = listing.output.as_ref()?.clone();
        let script = listing.script.as_ref().map(|path| format!("--devices={}", folder.path().join(path).display()));
        let options: Vec<&str> = [TIME_LIMIT].into_iter().chain(script.as_deref()).collect();
        let run = Lfz::run(&format!("guide-{}", listing.name), &write(folder.path(), &listing), &options);
        Some((listing.name, output, run))
    });
    for (name, output, run) in runs.collect::<Vec<_>>() {
        let finished = run.finish();
        assert_eq!(finished.code(), 0, "{name}: {finished}");
        assert_eq!(by_participant(finished.lines.iter()), by_participant(output.iter()), "{name}: {finished}");
    }
}

/// Returns the program's own output: the lines of one participant after those of another, because in time they mix.
fn by_participant<'a>(lines: impl Iterator<Item = &'a String>) -> Vec<&'a str> {
    let mut lines: Vec<(&str, &str)> = lines
        .map(|line| line.split_once(" | ").map_or(("", line.as_str()), |(name, _)| (name.trim_end(), line.as_str())))
        .filter(|(name, line)| *name != "RTI" && !line.contains("info: ") && !is_of_build(line))
        .collect();
    lines.sort_by_key(|(name, _)| *name);
    lines.into_iter().map(|(_, line)| line).collect()
}
