// SPDX-License-Identifier: Apache-2.0
//! Bindings of C headers for Rust.

use std::path::{Path, PathBuf};
use std::{env, fs, process};

use bindgen::callbacks::ParseCallbacks;
use bindgen::{BindgenError, Builder, EnumVariation};

use crate::floats;

/// Writes `c.rs` into `out`; `place` is where the program names the headers. Returns the C file with wrappers of
/// `static inline` functions. Zephyr's build has it at `LF_C_WRAPPER_FILE`.
pub(crate) fn bind(headers: &[PathBuf], includes: &[PathBuf], flags: &[String], place: &str, out: &Path) -> PathBuf {
    if let Err(reason) = clang_sys::load() {
        fail(&format!(
            "{place}: error: libclang, which reads headers, cannot be loaded: install it, on Debian and Ubuntu as \
             libclang-dev, or name its folder in LIBCLANG_PATH ({reason})"
        ));
    }
    let wrapper = out.join("c_wrapper.c");
    // Where nothing is static, bindgen writes none.
    write(&wrapper, "");
    let builder = || {
        let folders = includes.iter().map(|folder| format!("-I{}", folder.display()));
        let macros = flags.iter().filter(|flag| is_for_clang(flag)).cloned();
        builder(headers, &wrapper).clang_args(image_arguments().into_iter().chain(folders).chain(macros))
    };
    let mut bindings = generate(builder(), place);
    if variable("DEP_LF_ZEPHYR_FLOATS").is_some_and(|has| has == "false") {
        let unusable = floats::functions(&bindings);
        for function in &unusable {
            println!(
                "cargo::warning=the function `{function}` takes or gives floating-point numbers, which images for \
                 native_sim cannot pass between Rust and C: bodies cannot call it, but through a function of C that \
                 takes a pointer to them"
            );
        }
        if !unusable.is_empty() {
            write(&wrapper, "");
            bindings = generate(unusable.iter().fold(builder(), Builder::blocklist_function), place);
        }
    }
    write(&out.join("c.rs"), &bindings);
    if let Some(given) = variable("LF_C_WRAPPER_FILE") {
        // Without it the image cannot be linked.
        println!("cargo::rerun-if-changed={given}");
        let (text, given) = (fs::read(&wrapper).unwrap_or_default(), Path::new(&given));
        if fs::read(given).ok().as_ref() != Some(&text) {
            write(given, &String::from_utf8_lossy(&text));
        }
    }
    wrapper
}

/// Returns the selection and the form of the bindings.
fn builder(headers: &[PathBuf], wrapper: &Path) -> Builder {
    let mut builder = Builder::default()
        .use_core()
        // A value of an enumeration of C can be any number.
        .default_enum_style(EnumVariation::NewType { is_bitfield: false, is_global: false })
        .derive_default(true)
        .derive_eq(true)
        .derive_partialeq(true)
        .generate_cstr(true)
        .generate_comments(false)
        .layout_tests(false)
        .wrap_static_fns(true)
        .wrap_static_fns_path(wrapper)
        .wrap_static_fns_suffix("__of_program")
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()) as Box<dyn ParseCallbacks>);
    for header in headers {
        let name = header.display().to_string();
        // Their own includes are bound as far as they need them.
        builder = builder.allowlist_file(regex_of(&name)).header(name);
    }
    builder
}

/// Returns the arguments that the platform's headers need, and the folders and macros of the image's C files.
fn image_arguments() -> Vec<String> {
    let platform = variable("DEP_LF_ZEPHYR_CLANG_ARGUMENTS").unwrap_or_default();
    let mut arguments: Vec<String> = platform.split_terminator('\t').map(str::to_owned).collect();
    if let Some(file) = variable("LF_C_FLAGS_FILE") {
        println!("cargo::rerun-if-changed={file}");
        let flags = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file} cannot be read: {error}"));
        arguments.extend(flags.lines().filter(|flag| flag.len() > 2).map(str::to_owned));
    }
    arguments
}

/// Returns whether an argument of the C compiler is about macros or folders, which is all that matters for headers;
/// clang may not know others.
fn is_for_clang(flag: &str) -> bool {
    ["-D", "-U", "-I"].iter().any(|kind| flag.strip_prefix(kind).is_some_and(|rest| !rest.is_empty()))
}

fn generate(builder: Builder, place: &str) -> String {
    match builder.generate() {
        Ok(bindings) => bindings.to_string(),
        // It is a compiler's message, with positions.
        Err(BindgenError::ClangDiagnostic(text)) => fail(&text),
        Err(error) => fail(&format!("{place}: error: the headers cannot be bound: {error}")),
    }
}

fn fail(message: &str) -> ! {
    eprintln!("{}", message.trim_end());
    process::exit(1);
}

fn variable(name: &str) -> Option<String> {
    println!("cargo::rerun-if-env-changed={name}");
    env::var(name).ok()
}

fn write(file: &Path, text: &str) {
    fs::write(file, text).unwrap_or_else(|error| panic!("{} cannot be written: {error}", file.display()));
}

/// Returns a regular expression that only this text matches.
fn regex_of(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '/' | '_' | '-' | ' ');
    text.chars().map(|c| if is_plain(c) { c.to_string() } else { format!("\\{c}") }).collect()
}
