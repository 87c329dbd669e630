// SPDX-License-Identifier: Apache-2.0
//! However deeply a program is nested, the compiler ends with an error that names the place, and not with a stack
//! overflow; and all later stages accept the programs that the check accepts.

use std::collections::BTreeMap;

use lf_compiler::deployment::Deployment;
use lf_compiler::emit::{Settings, emit};
use lf_compiler::{Code, Compilation, compile};

/// The opening, the inner and the closing text.
type Pattern = (&'static str, &'static str, &'static str);

/// Nested expressions of Rust.
const EXPRESSIONS: &[Pattern] = &[
    ("(", "1", ")"),
    ("[", "1", "]"),
    ("{", "1", "}"),
    ("!", "true", ""),
    ("-", "1", ""),
    ("- ", "1", ""),
    ("*", "x", ""),
    ("&", "x", ""),
    ("&&&", "x", ""),
    ("a && &&", "x", ""),
    ("||", "1", ""),
    ("|a, b| ", "1", ""),
    ("|a: B<C, D>, e| ", "1", ""),
    ("move || ", "1", ""),
    ("f(", "1", ")"),
    ("a.b(", "1", ")"),
    ("a[", "1", "]"),
    ("a::<", "b", ">"),
    ("a::<b, ", "c", ">"),
    ("a::< b, ", "c", " >"),
    ("<", "A", " as B>::C"),
    ("<<", "A", " as B>::C as D>::E"),
    ("if x {", "1", "}"),
    ("if x { 1 } else {", "1", "}"),
    ("if x { 1 } else ", "{ 2 }", ""),
    ("if ", "a {}", " {}"),
    ("match ", "a {}", " {}"),
    ("match a { b => ", "1", "}"),
    ("match a { b => {}, c => {", "1", "} }"),
    ("match a { b if x < y => ", "1", "}"),
    ("return ", "1", ""),
    ("break ", "1", ""),
    ("a = ", "1", ""),
    ("a += ", "1", ""),
    ("a + ", "1", ""),
    ("a || ", "b", ""),
    ("a == 1 && ", "b", ""),
    ("a as ", "B", ""),
    ("", "a", " as B"),
    ("", "a", ".b()"),
    ("", "a", "?"),
    ("", "a", "(1)"),
    ("", "a", "[1]"),
    ("", "a", "::b"),
    ("..", "1", ""),
    ("a..", "1", ""),
    ("loop {", "1", "}"),
    ("unsafe {", "1", "}"),
    ("async move {", "1", "}"),
    ("const {", "1", "}"),
    ("'a: {", "1", "}"),
    ("S { a: ", "1", "}"),
    ("m![", "1", "]"),
    ("fn f() {", "1", "}"),
    ("mod a {", "", "}"),
    ("#[a(", "1", ")] 1"),
    ("let a = {", "1;", "};"),
    ("if let A(b) = c && ", "d", " {}"),
];

/// Nested types of Rust.
const TYPES: &[Pattern] = &[
    ("<", "", ""),
    ("(", "u8", ",)"),
    ("[", "u8", "; 4]"),
    ("Vec<", "u8", ">"),
    ("A<u8, ", "u8", ">"),
    ("A < u8, ", "u8", " >"),
    ("&", "u8", ""),
    ("&'static mut ", "u8", ""),
    ("*const ", "u8", ""),
    ("fn() -> ", "u8", ""),
    ("fn(", "u8", ")"),
    ("dyn Fn() -> ", "u8", ""),
    ("Box<dyn Fn(", "u8", ")>"),
    ("<", "A", " as B>::C"),
    ("impl A<B = ", "u8", ">"),
    ("[u8; {", "1", "}]"),
    ("A + ", "B", ""),
    ("a::", "B", ""),
];

/// Nested items of Rust.
const ITEMS: &[Pattern] = &[
    ("mod a {", "", "}"),
    ("fn f() {", "", "}"),
    ("impl A { fn f() {", "", "} }"),
    ("use a::", "b;", ""),
    ("use a::{", "b", "};"),
    ("use a::{b, ", "c", "};"),
    ("type A = B<", "u8", ">;"),
    ("const A: u8 = (", "1", ");"),
    ("m!{", "1", "}"),
    ("#[a] ", "struct A;", ""),
    ("macro_rules! m { () => {", "", "} }"),
    ("struct A { b: (", "u8", ",) }"),
];

/// Nested code of C.
const OF_C: &[Pattern] =
    &[("(", "1", ");"), ("{", ";", "}"), ("f(", "1", ");"), ("if (x) {", ";", "}"), ("a[", "1", "];")];

fn nested((open, within, close): &Pattern, times: usize) -> String {
    open.repeat(times) + within + &close.repeat(times)
}

fn compiled(text: String) -> Compilation {
    compile("p.lf", &BTreeMap::from([("p.lf".to_owned(), text)]))
}

/// Returns programs with the code in all possible places.
fn programs(times: usize) -> Vec<String> {
    let of_rust = |place: &str, code: String| {
        "target Rust\nreactor A(p: usize = 0) {\n  state s: usize = 0\n  ".to_owned()
            + &place.replace('@', &code)
            + "\n}\nmain reactor { a = new A() }\n"
    };
    let mut all = Vec::new();
    for pattern in EXPRESSIONS {
        let code = nested(pattern, times);
        all.push(of_rust("reaction(startup) {= @ =}", code.clone()));
        all.push(of_rust("state x: i32 = {= @ =}", code.clone()));
        all.push(of_rust("input[{= @ =}] x: i32", code));
    }
    for pattern in TYPES {
        let code = nested(pattern, times);
        all.push(of_rust("input x: {= @ =}", code.clone()));
        all.push(of_rust("state x: {= @ =} = {= 1 =}", code.clone()));
        all.push(of_rust("reaction(startup) {= let a: @ = 1; =}", code));
    }
    for pattern in ITEMS {
        all.push(of_rust("preamble {= @ =}", nested(pattern, times)));
        all.push(format!("target Rust\npreamble {{= {} =}}\nmain reactor {{ }}\n", nested(pattern, times)));
    }
    for pattern in OF_C {
        all.push(format!("target C\nmain reactor {{ reaction(startup) {{= {} =}} }}\n", nested(pattern, times)));
    }
    all
}

#[test]
fn code_that_is_nested_too_deeply_is_refused_without_an_overflow() {
    for program in programs(20_000) {
        let compilation = compiled(program.clone());
        let mut codes = compilation.diagnostics.iter().map(|entry| entry.code);
        // Code with an earlier error is not parsed any further, and reports that error.
        assert!(codes.any(|code| matches!(code, Code::NestingTooDeep | Code::CodeSyntax)), "{}", &program[..200]);
    }
}

/// The tests' threads have stacks of 2 MiB, a quarter of the program's.
#[test]
fn code_that_passes_the_check_passes_all_later_stages() {
    let deployment = Deployment::default();
    let settings = Settings { crates: "/rust", version: "0.0.0", current: "/", deployment: &deployment, keys: "/keys" };
    let mut taken = 0;
    for times in [20, 40, 80, 120, 160, 200, 250] {
        for program in programs(times) {
            if let Some(plan) = compiled(program).plan {
                taken += 1;
                let _ = emit(&plan, &settings);
            }
        }
    }
    assert!(taken > 200, "only {taken} programs were taken");
}

#[test]
fn a_chain_of_imports_is_followed_to_a_limit() {
    let file =
        |number: usize| (format!("f{number}.lf"), format!("target Rust\nimport A from \"f{}.lf\"\n", number + 1));
    let files: BTreeMap<String, String> = (0..5_000).map(file).collect();
    let compilation = compile("f0.lf", &files);
    assert!(compilation.diagnostics.iter().any(|entry| entry.code == Code::NestingTooDeep));
}

#[test]
fn reactors_that_inherit_from_two_that_do_are_followed_once_each() {
    let level = |number: usize| {
        format!("reactor A{0} extends A{1}, B{1} {{ }}\nreactor B{0} extends A{1}, B{1} {{ }}\n", number + 1, number)
    };
    let text: String = (0..60).map(level).collect();
    let text = format!("target Rust\nreactor A0 {{ }}\nreactor B0 {{ }}\n{text}main reactor {{ a = new A60() }}\n");
    assert!(compiled(text).plan.is_some());
}
