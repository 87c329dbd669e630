// SPDX-License-Identifier: Apache-2.0
//! The advice in messages and documents can be followed.

use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory;
use lfz::args::Cli;

/// Adds the sources and documents below a folder, except for generated ones.
fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("it is a folder of the repository").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() && !name.starts_with('.') && !matches!(name.as_str(), "target" | "build") {
            texts(&path, found);
        } else if path.extension().is_some_and(|kind| kind == "rs" || kind == "md" || kind == "py") {
            found.push(path);
        }
    }
}

/// Returns the commands in backquotes that begin with the name of the program, as words.
fn commands(text: &str) -> impl Iterator<Item = Vec<&str>> {
    let quoted = text.split(concat!("`", "lfz ")).skip(1).filter_map(|rest| rest.split(['`', '\n']).next());
    quoted.map(|command| command.split([' ', ',', ';', '[', ']']).filter(|word| !word.is_empty()).collect())
}

#[test]
fn each_command_and_option_that_a_text_names_exists() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("it lies in the repository");
    let mut files = Vec::new();
    texts(repository, &mut files);
    let cli = Cli::command();
    let mut count = 0;
    for file in files {
        let text = fs::read_to_string(&file).expect("it is text");
        for words in commands(&text) {
            let name = words.first().copied().unwrap_or_default();
            if name == "help" || !name.starts_with(|first: char| first.is_ascii_lowercase()) {
                continue;
            }
            let place = file.display();
            let command = cli.find_subcommand(name);
            let command = command.unwrap_or_else(|| panic!("{place} names `lfz {name}`, which does not exist"));
            let known = |option: &str| command.get_arguments().any(|argument| argument.get_long() == Some(option));
            for option in words.iter().take_while(|word| **word != "--").filter_map(|word| word.strip_prefix("--")) {
                assert!(known(option), "{place} names `lfz {name} --{option}`, which does not exist");
            }
            count += 1;
        }
    }
    assert!(count > 20, "only {count} commands were found");
}
