// SPDX-License-Identifier: Apache-2.0
//! Installs the grammar and its queries for an editor, or writes the generated parser, as `tree-sitter generate` does.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// The folder with the grammar.
const GRAMMAR: &str = env!("CARGO_MANIFEST_DIR");

const USAGE: &str = "usage: tree-sitter-lf                            writes the parser to `src`
       tree-sitter-lf helix|neovim [FOLDER]     installs it for an editor, or in its runtime folder FOLDER";

/// An editor that loads grammars from a folder.
struct Editor {
    name: &'static str,
    /// The runtime folder below the user's configuration.
    runtime: &'static str,
    /// The compiled grammar in the runtime folder.
    library: &'static str,
    /// The queries that the editor reads.
    queries: &'static [&'static str],
}

const EDITORS: [Editor; 2] = [
    Editor {
        name: "helix",
        runtime: "helix/runtime",
        library: "grammars/lf.so",
        queries: &["highlights", "indents", "injections", "locals", "tags", "textobjects"],
    },
    Editor {
        name: "neovim",
        runtime: "nvim",
        library: "parser/lf.so",
        queries: &["folds", "highlights", "injections"],
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let editor = arguments.first().and_then(|name| EDITORS.iter().find(|editor| editor.name == *name));
    let done = match (editor, &arguments[..]) {
        (None, []) => generate().map(|source| println!("the parser is in {}", source.display())),
        (Some(editor), [_]) => install(editor, None),
        (Some(editor), [_, folder]) => install(editor, Some(Path::new(folder))),
        _ => Err(USAGE.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the generated files beside the scanner, and returns their folder.
fn generate() -> Result<PathBuf, String> {
    let source = Path::new(GRAMMAR).join("src");
    for (path, text) in tree_sitter_lf::GENERATED {
        let file = source.join(path);
        make_folder_of(&file)?;
        fs::write(&file, text).map_err(|error| cannot_write(&file, &error))?;
    }
    Ok(source)
}

/// Compiles the grammar into an editor's runtime folder, and copies the queries there.
fn install(editor: &Editor, folder: Option<&Path>) -> Result<(), String> {
    let folder = match folder {
        Some(folder) => folder.to_path_buf(),
        None => configuration()?.join(editor.runtime),
    };
    let (source, library) = (generate()?, folder.join(editor.library));
    make_folder_of(&library)?;
    let mut compiler = Command::new(env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.args(["-std=c11", "-O2", "-fPIC", "-shared", "-I"]).arg(&source);
    compiler.args(["parser.c", "scanner.c"].map(|file| source.join(file))).arg("-o").arg(&library);
    match compiler.status() {
        Ok(status) if status.success() => {}
        Ok(status) => return Err(format!("the C compiler ends with {status}")),
        Err(error) => return Err(format!("cannot start a C compiler, named by CC or `cc`: {error}")),
    }
    for query in editor.queries {
        let file = folder.join(format!("queries/lf/{query}.scm"));
        make_folder_of(&file)?;
        let from = Path::new(GRAMMAR).join(format!("queries/{query}.scm"));
        fs::copy(from, &file).map_err(|error| cannot_write(&file, &error))?;
    }
    println!("the grammar and its queries are in {}", folder.display());
    Ok(())
}

/// Returns the folder of the user's configuration.
fn configuration() -> Result<PathBuf, String> {
    let own = env::var_os("XDG_CONFIG_HOME").filter(|path| !path.is_empty()).map(PathBuf::from);
    own.or_else(|| Some(PathBuf::from(env::var_os("HOME")?).join(".config")))
        .ok_or_else(|| "HOME does not say where the editor's configuration is: name the folder".to_owned())
}

fn make_folder_of(file: &Path) -> Result<(), String> {
    let folder = file.parent().unwrap_or(file);
    fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write {}: {error}", path.display())
}
