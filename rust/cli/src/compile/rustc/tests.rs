// SPDX-License-Identifier: Apache-2.0
//! Diagnostics as rustc writes them, about a program whose second line is line 7 of the generated file.

use super::{Diagnostic, LfPlace, Origin, Scope, byte_of, render_all};

const TEXT: &str = "reaction(t) {=\n    let é: u8 = \"x\";\n=}\n";
const BODY_COLUMN_SHIFT: usize = 4;

struct Program;

impl Origin for Program {
    fn place(&self, generated: &str, line: usize, column: usize) -> Option<LfPlace> {
        let place = |line, column, verbatim| LfPlace { path: "src/P.lf".to_owned(), line, column, verbatim };
        match (generated, line) {
            ("a/src/main.rs", 7) => Some(place(2, column - BODY_COLUMN_SHIFT, true)),
            ("a/src/main.rs", 3) => Some(place(1, 1, false)),
            _ => None,
        }
    }

    fn text(&self, path: &str) -> Option<&str> {
        (path == "src/P.lf").then_some(TEXT)
    }

    fn scopes(&self) -> &[Scope] {
        &[]
    }
}

fn text_of(diagnostics: &[Diagnostic]) -> String {
    render_all(diagnostics, &Program, false).text
}

fn span(file: &str, line: usize, columns: (usize, usize), rest: &str) -> String {
    format!(
        r#"{{"file_name":"{file}","line_start":{line},"line_end":{line},"column_start":{},"column_end":{},
        "byte_start":0,"byte_end":0,"is_primary":true,"text":[],"label":"expected `u8`, found `&str`",
        "suggested_replacement":null,"suggestion_applicability":null,{rest}}}"#,
        columns.0, columns.1
    )
}

fn diagnostic(level: &str, spans: &[String], children: &str) -> Diagnostic {
    let spans = spans.join(",");
    let json = format!(
        r#"{{"$message_type":"diagnostic","message":"mismatched types","code":{{"code":"E0308","explanation":null}},
        "level":"{level}","spans":[{spans}],"children":[{children}],"rendered":"as rustc prints it\n"}}"#
    );
    serde_json::from_str(&json).expect("the test writes what rustc writes")
}

#[test]
fn an_error_in_a_body_is_shown_in_the_lf_file() {
    let child = r#"{"message":"first line\nsecond line","code":null,"level":"note","spans":[],"children":[],
        "rendered":null}"#;
    let error = diagnostic("error", &[span("a/src/main.rs", 7, (21, 24), r#""expansion":null"#)], child);
    let text = text_of(&[error.clone(), error]);
    assert_eq!(
        text,
        "src/P.lf:2:17: error[E0308]: mismatched types\n  |\n2 |     let é: u8 = \"x\";\n  \
         |                 ^^^ expected `u8`, found `&str`\n  note: first line\n    second line\n\n"
    );
}

#[test]
fn errors_of_one_kind_in_one_line_are_all_shown() {
    let [one, other] = [(21, 24), (16, 18)]
        .map(|columns| diagnostic("error", &[span("a/src/main.rs", 7, columns, r#""expansion":null"#)], ""));
    let shown = render_all(&[one.clone(), other.clone(), one], &Program, false);
    assert_eq!(shown.errors, 2, "{}", shown.text);
    assert!(shown.text.contains("2:12: error") && shown.text.contains("2:17: error"), "{}", shown.text);
}

#[test]
fn a_suggestion_is_repeated() {
    let replaced = span("a/src/main.rs", 7, (21, 24), r#""expansion":null"#)
        .replace(r#""suggested_replacement":null"#, r#""suggested_replacement":"b'x'""#);
    let child =
        format!(r#"{{"message":"use a byte","code":null,"level":"help","spans":[{replaced}],"rendered":null}}"#);
    let error = diagnostic("error", &[span("a/src/main.rs", 7, (21, 24), r#""expansion":null"#)], &child);
    assert!(text_of(&[error]).contains("  help: use a byte: `b'x'`\n"));
}

#[test]
fn an_error_in_a_macro_is_shown_where_the_macro_is_used() {
    let used = span("a/src/main.rs", 7, (8, 10), r#""expansion":null"#);
    let expansion = format!(r#""expansion":{{"span":{used},"macro_decl_name":"println!","def_site_span":null}}"#);
    let error = diagnostic("error", &[span("/rustc/library/std/src/macros.rs", 100, (1, 2), &expansion)], "");
    assert!(text_of(&[error]).starts_with("src/P.lf:2:4: error[E0308]"));
}

#[test]
fn an_error_in_generated_code_names_the_declaration_and_shows_the_code() {
    let error = diagnostic("error", &[span("a/src/main.rs", 3, (1, 2), r#""expansion":null"#)], "");
    let text = text_of(&[error]);
    assert!(text.starts_with("src/P.lf:1:1: error[E0308]: mismatched types\n"), "{text}");
    assert!(text.ends_with("in the code that is generated for this:\nas rustc prints it\n\n"), "{text}");
}

#[test]
fn an_error_in_generated_code_is_left_out_where_one_in_the_program_explains_it() {
    let scaffolding = diagnostic("error", &[span("a/src/main.rs", 3, (1, 2), r#""expansion":null"#)], "");
    let elsewhere = diagnostic("error", &[span("other.rs", 1, (1, 2), r#""expansion":null"#)], "");
    let body = diagnostic("error", &[span("a/src/main.rs", 7, (21, 24), r#""expansion":null"#)], "");
    let alone = text_of(std::slice::from_ref(&body));
    assert_eq!(text_of(&[scaffolding, elsewhere, body]), alone);
}

#[test]
fn messages_without_a_place_in_the_program_are_shown_unchanged() {
    let error = diagnostic("error", &[span("other.rs", 1, (1, 2), r#""expansion":null"#)], "");
    assert_eq!(text_of(&[error]), "as rustc prints it\n\n");
}

#[test]
fn a_warning_is_shown_only_where_the_user_can_mend_it() {
    let body = diagnostic("warning", &[span("a/src/main.rs", 7, (21, 24), r#""expansion":null"#)], "");
    assert!(text_of(&[body]).starts_with("src/P.lf:2:17: warning[E0308]"));
    let scaffolding = diagnostic("warning", &[span("a/src/main.rs", 3, (1, 2), r#""expansion":null"#)], "");
    assert_eq!(text_of(&[scaffolding]), "");
}

#[test]
fn sums_of_other_diagnostics_are_left_out() {
    let mut sum = diagnostic("error", &[], "");
    sum.message = "aborting due to 2 previous errors".to_owned();
    assert_eq!(text_of(&[sum]), "");
}

#[test]
fn columns_are_characters() {
    assert_eq!(byte_of(TEXT, 2, 1), 15);
    assert_eq!(byte_of(TEXT, 2, 10), TEXT.find(": u8").expect("it is there"));
    assert_eq!(byte_of(TEXT, 2, 99), TEXT.find("\n=}").expect("it is there"));
    assert_eq!(byte_of(TEXT, 99, 1), TEXT.len());
}
