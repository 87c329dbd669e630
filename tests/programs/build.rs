// SPDX-License-Identifier: Apache-2.0
//! Compiles the LF programs of the folder `programs` to what `lfz` generates of them, one module for each participant,
//! and the C of the one whose bodies are C.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use lf_compiler::deployment::Deployment;
use lf_compiler::emit::{Emitted, Settings, emit};
use lf_compiler::{Style, compile};

/// The program of which one participant has bodies in C: a program that is linked has one set of them.
const IN_C: (&str, &str) = ("in_c", "node");

fn main() {
    println!("cargo::rerun-if-changed=programs");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo says where build scripts write"));
    let sources: BTreeMap<String, String> = fs::read_dir("programs")
        .expect("the programs lie beside the manifest")
        .map(|entry| entry.expect("the folder can be read").path())
        .map(|path| (path.display().to_string(), fs::read_to_string(&path).expect("it is a text")))
        .collect();
    let modules: String = sources.keys().map(|path| module(path, &generate(path, &sources), &out)).collect();
    write(&out.join("programs.rs"), &modules);
    lf_c_build::program().folder(out.join(IN_C.0).join(IN_C.1).join("c")).flag("-Wall").build();
}

/// Compiles a program.
fn generate(path: &str, sources: &BTreeMap<String, String>) -> Emitted {
    let compilation = compile(path, sources);
    let plan = compilation.plan.unwrap_or_else(|| panic!("{}", compilation.diagnostics.render(Style::Plain)));
    let deployment = Deployment::default();
    let settings = Settings { crates: "", version: "", current: "", deployment: &deployment, keys: "" };
    emit(&plan, &settings).unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Writes the files of a program; its module, with one for each participant, whose root is that of its crate.
fn module(path: &str, emitted: &Emitted, out: &Path) -> String {
    let program = snake_case(Path::new(path).file_stem().and_then(|stem| stem.to_str()).expect("it has a name"));
    for file in &emitted.files {
        let participant = file.path.split('/').next().unwrap_or_default();
        // Here its crate is a module.
        let text = file.text.replace("crate::", &format!("crate::{program}::{participant}::"));
        write(&out.join(&program).join(&file.path), &text);
    }
    let participant = |folder: &str| {
        let root = out.join(&program).join(folder).join("src/lib.rs");
        let allowed = "#[allow(clippy::unwrap_used, missing_docs, nonstandard_style, unreachable_pub)]";
        format!("    {allowed}\n    #[path = \"{}\"]\n    pub mod {folder};\n", root.display())
    };
    let participants: String = emitted.participants.iter().map(|it| participant(&it.folder)).collect();
    format!("/// The program `{path}`.\npub mod {program} {{\n{participants}}}\n")
}

/// Writes a file that looks older than this run, so that cargo does not take it for a change since.
fn write(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().expect("it is in a folder")).expect("cargo's folder can be written to");
    fs::write(path, text).expect("cargo's folder can be written to");
    let file = File::options().write(true).open(path).expect("it was just written");
    file.set_modified(SystemTime::UNIX_EPOCH).expect("the time of a file can be set");
}

/// `InC` becomes `in_c`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}
