// SPDX-License-Identifier: Apache-2.0
//! `lfz check`

use std::path::Path;
use std::process::ExitCode;

use lf_compiler::diagnostics::{SourceTexts, Span};
use lf_compiler::{Diagnostic, Diagnostics, Severity};
use serde_json::{Value, json};

use crate::args::{CheckArgs, Platform};
use crate::compile::{Program, Request, STANDARD_INPUT, compile, compile_input, count, read_deployment};
use crate::failure::Failure;
use crate::terminal;

/// Prints the errors of programs, or that they have none. All programs are checked, whatever is wrong with one.
pub(super) fn check(arguments: &CheckArgs) -> Result<ExitCode, Failure> {
    if arguments.json {
        return print_json(arguments);
    }
    let mut is_well = true;
    for file in &arguments.files {
        let name = if is_standard_input(file) { "standard input".into() } else { file.to_string_lossy() };
        match checked(file, arguments) {
            Ok(_) if terminal::is_quiet() => {}
            Ok(Checked { counts: (errors, warnings), cmake }) => {
                terminal::print(format_args!("{name}: {}{}", count(errors, warnings), only_built(&cmake)))?;
            }
            Err(Failure::Reported) => is_well = false,
            Err(Failure::Message(text)) => {
                terminal::report(format_args!("error: {text}"));
                is_well = false;
            }
        }
    }
    Ok(if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A program without errors.
struct Checked {
    /// The number of errors and of warnings.
    counts: (usize, usize),
    /// The files for CMake.
    cmake: Vec<String>,
}

/// Returns what is not known yet: only CMake reads its files.
fn only_built(cmake: &[String]) -> String {
    if cmake.is_empty() { String::new() } else { format!("; {} will be read by CMake in a build", cmake.join(", ")) }
}

/// Checks a program.
fn checked(file: &Path, arguments: &CheckArgs) -> Result<Checked, Failure> {
    let is_input = is_standard_input(file);
    if is_input && arguments.bodies {
        return Err(Failure::message("the standard input has no folder for the crates that --bodies needs"));
    }
    let (plan, counts) = if arguments.bodies {
        let platform = Some(Platform::Host);
        let built = Request { platform, checks_only: true, ..Request::new(file, &arguments.places) }.build()?;
        (built.plan, built.counts)
    } else {
        let program = if is_input { Program::of(compile_input()?, "standard input") } else { Program::load(file) }?;
        let counts = program.diagnostics.counts();
        (program.plan, counts)
    };
    if let Some(path) = &arguments.deployment {
        read_deployment(path, &plan)?;
    }
    let cmake =
        if arguments.bodies { Vec::new() } else { plan.target.c.cmake.into_iter().map(|file| file.path).collect() };
    Ok(Checked { counts, cmake })
}

fn is_standard_input(file: &Path) -> bool {
    file == Path::new(STANDARD_INPUT)
}

/// Prints all diagnostics as one list, for other programs.
fn print_json(arguments: &CheckArgs) -> Result<ExitCode, Failure> {
    let (mut all, mut is_well) = (Vec::new(), true);
    for file in &arguments.files {
        let compilation = if is_standard_input(file) { compile_input()? } else { compile(file)? };
        is_well &= !compilation.diagnostics.has_errors();
        all.extend(described(&compilation.diagnostics));
    }
    terminal::print(format_args!("{:#}", Value::Array(all)))?;
    Ok(if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn described(diagnostics: &Diagnostics) -> impl Iterator<Item = Value> {
    let sources = diagnostics.sources();
    diagnostics.iter().map(move |Diagnostic { code, span, message, label, secondary, hint }| {
        let related: Vec<Value> = secondary
            .iter()
            .map(|other| {
                let mut value = place(sources, other.span);
                value["text"] = json!(other.text);
                value
            })
            .collect();
        let mut value = place(sources, *span);
        value["severity"] = json!(match code.severity() {
            Severity::Error => "error",
            Severity::Warning => "warning",
        });
        value["code"] = json!(code.text());
        value["message"] = json!(message);
        value["label"] = json!(label);
        value["hint"] = json!(hint);
        value["related"] = json!(related);
        value
    })
}

/// Returns a place: lines and columns count from 1, columns in characters, and the end is exclusive.
fn place(sources: &SourceTexts, span: Span) -> Value {
    let Some(file) = sources.get(span.file) else { return json!({}) };
    let (start, end) = (file.position(span.start), file.position(span.end));
    json!({ "file": file.path(), "line": start.line, "column": start.column,
        "end_line": end.line, "end_column": end.column })
}
