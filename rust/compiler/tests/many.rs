// SPDX-License-Identifier: Apache-2.0
//! The compiler's messages stay short for programs with thousands of errors, or of channels in a connection.

use std::collections::BTreeMap;

use lf_compiler::{Code, Compilation, Style, compile};

fn compiled(text: String) -> Compilation {
    compile("p.lf", &BTreeMap::from([("p.lf".to_owned(), text)]))
}

#[test]
fn the_first_hundred_mistakes_are_shown_and_all_are_counted() {
    let wrong = "reactor A { x }\n".repeat(20_000);
    let compilation = compiled(format!("target Rust\n{wrong}main reactor {{ }}\n"));
    let text = compilation.diagnostics.render(Style::Plain);
    let (errors, _) = compilation.diagnostics.counts();
    assert_eq!(text.matches(": error[").count(), 100);
    assert!(
        errors >= 20_000
            && text.ends_with(&format!("and {} more errors, which may follow from these\n\n", errors - 100))
    );
}

/// Warnings come first in this text.
#[test]
fn an_error_is_shown_however_many_warnings_there_are() {
    let older = "  state s@(1)\n";
    let states: String = (0..300).map(|number| older.replace('@', &number.to_string())).collect();
    let compilation =
        compiled(format!("target Rust\nreactor A {{\n{states}  input x: u8\n  x -> y\n}}\nmain reactor {{ }}\n"));
    let text = compilation.diagnostics.render(Style::Plain);
    assert_eq!((text.matches(": error[").count(), text.matches(": warning[").count()), (1, 99), "{text}");
    assert!(text.contains("and 201 more warnings"), "{text}");
}

#[test]
fn errors_in_a_line_of_megabytes_show_a_part_of_it() {
    let compilation = compiled(format!("target Rust; {} main reactor {{ }}", "reactor A { x } ".repeat(50_000)));
    assert!(compilation.diagnostics.render(Style::Plain).len() < 200_000);
}

#[test]
fn a_mesh_has_one_warning_with_the_number_of_its_channels() {
    let compilation = compiled(
        "target Rust\nreactor A(bank_index: usize = 0) { input[100] x: u8; output y: u8; reaction(x) -> y {= =} }\n\
         main reactor { a = new[100] A(); (a.y)+ -> a.x after 1 msec }\n"
            .to_owned(),
    );
    assert!(compilation.plan.is_some());
    let unknown: Vec<_> = compilation.diagnostics.iter().filter(|entry| entry.code == Code::UnknownCapacity).collect();
    assert_eq!(unknown.len(), 1);
    assert!(unknown[0].message.ends_with("and so it is with 9999 other channels"), "{}", unknown[0].message);
}

#[test]
fn a_reactor_with_too_many_reactions_is_refused_while_it_is_read() {
    let reactions = "reaction(startup) {= =}\n".repeat(70_000);
    let compilation = compiled(format!("target Rust\nmain reactor {{\n{reactions}}}\n"));
    let codes: Vec<_> = compilation.diagnostics.iter().map(|entry| entry.code).collect();
    assert_eq!(codes, [Code::TooLarge]);
}

#[test]
fn a_name_of_a_file_that_folders_cannot_have_is_refused() {
    let named = |name: &str| {
        let files = BTreeMap::from([(name.to_owned(), "target Rust\nmain reactor { }\n".to_owned())]);
        compile(name, &files).diagnostics.iter().map(|entry| entry.code).collect::<Vec<_>>()
    };
    for right in ["2Motors.lf", "Build.lf", "src/a.b.lf", "con.lf", "core.lf", "_x.lf", "Ünï.lf", "a-b.lf"] {
        assert_eq!(named(right), [], "{right}");
    }
    let long = "a".repeat(130) + ".lf";
    for wrong in ["-dash.lf", "quo\"te.lf", "a b.lf", "a\nb.lf", "$x.lf", "a;b.lf", ".lf", "a\u{200B}b.lf", &long] {
        assert_eq!(named(wrong), [Code::FileName], "{wrong}");
    }
}
