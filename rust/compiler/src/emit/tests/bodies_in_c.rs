// SPDX-License-Identifier: Apache-2.0
//! The emitted files of a program whose bodies are C.

use std::collections::BTreeMap;

use super::{all_on, emit_on, listing, refused, settings};
use crate::compile;
use crate::deployment::Deployment;
use crate::emit::{Emitted, emit};

const TEXT: &str = r#"target C { timeout: 1 sec }
preamble {=
    typedef struct { int a; double b; } pair_t;
=}
reactor Source(n: int = 3, list: int[] = {1, 2, 3}) {
  output y: pair_t
  output[2] m: int
  timer t(0, 100 msec)
  logical action a(10 msec): int
  state array: int[2] = {= { n, 2 } =}
  method plus(k: int): int {= return k + self->n; =}
  reaction(t) -> y, a, m {=
    lf_set(m[m_width - 1], plus(1));
  =}
  reaction(a) {= lf_print("%d", a->value); =} deadline(1 msec) {= lf_print("late"); =}
}
reactor Sink(weight: float = 0.5) {
  input x: int
  input w: int
  physical action p: char*
  reaction(x, w) -> p {= lf_schedule(p, 0); =}
}
reactor Last { input z: pair_t  reaction(z) {= =} }
federated reactor (first: int = 4) {
  s = new Source(n = first)
  l = new Last()
  s.y -> l.z
}
reactor Inside {
  s = new Source()
  k = new[2] Sink(weight = {= 0.1f * bank_index =})
  s.m -> k.x after 5 msec
  reaction(s.y) -> k.w {= lf_set(k[1].w, s.y->value.a); =}
}
"#;

/// Bodies that are functions, with all kinds of ports.
const FUNCTIONS: &str = r#"target C
preamble {= typedef struct { int a; } pair; =}
reactor Numbers(first: int = 0) {
  output one: int
  output[2] several: int
  reaction number(startup) -> one, several
}
reactor Keeper<T> {
  mutable input x: T
  input[3] more: T
  physical action again
  state last: T
  reaction keep(x, more) -> again deadline(1 msec) {= lf_print("late"); =}
}
reactor Other<T> { output[3] list: T }
main reactor {
  bank = new[2] Numbers()
  single = new Numbers()
  keeper = new Keeper<pair>()
  other = new Other<char*>()
  reaction collect(bank.one, bank.several, single.one, other.list) -> keeper.x
}
"#;

fn emitted(text: &str) -> String {
    let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text.to_owned())])).plan.expect("it is right");
    listing(&emit_on(&plan, &Deployment::default()))
}

#[test]
fn one_function_is_not_the_body_of_reactions_of_two_reactors() {
    let text = "target C\nreactor A { reaction f(startup) }\nreactor B { reaction f(startup) }\n\
                main reactor { a = new A()  b = new B() }\n";
    let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text.to_owned())])).plan.expect("it is right");
    let errors = refused(&plan);
    let told = "P.lf:3:13: error: the function `f` is the body of reactions of both `A` and `B`, whose `self` differ: \
                give one of the reactions another name, or a body";
    assert_eq!(errors.iter().map(ToString::to_string).collect::<Vec<_>>(), [told]);
}

/// Returns the lines of generated files that have one of these words.
fn lines_with(emitted: &Emitted, words: &[&str]) -> Vec<String> {
    let lines = emitted.files.iter().flat_map(|file| file.text.lines());
    lines.filter(|line| words.iter().any(|word| line.contains(word))).map(|line| line.trim().to_owned()).collect()
}

const LINKING: &str =
    "target C { compiler-flags: [\"-Llib -l own\", \"-O2\", \"-I\", \"inc\", \"lib/libx.a\", \"-pthread\",
  \"-Xlinker -Map=a.map -Wl,-z,now -rdynamic -u start -undef\"] }\nmain reactor { }\n";

#[test]
fn words_for_the_linker_are_told_to_the_linker_and_paths_begin_beside_the_program() {
    let plan = compile("a b/P.lf", &BTreeMap::from([("a b/P.lf".to_owned(), LINKING.to_owned())])).plan;
    let plan = plan.expect("it is right");
    let host = emit_on(&plan, &Deployment::default());
    let flags = [r#".flag("-O2")"#, r#".flag("-I/HERE/a b/inc")"#, r#".flag("-pthread")"#, r#".flag("-undef")"#];
    let linked = [
        r#".link_argument("-L/HERE/a b/lib")"#,
        r#".link_argument("-lown")"#,
        r#".link_argument("/HERE/a b/lib/libx.a")"#,
        r#".link_argument("-pthread")"#,
        r#".link_argument("-Wl,-Map=a.map")"#,
        r#".link_argument("-Wl,-z,now")"#,
        r#".link_argument("-rdynamic")"#,
        r#".link_argument("-ustart")"#,
    ];
    let here = format!("{}/", settings(&Deployment::default()).current);
    let lines = lines_with(&host, &[".flag(\"-O", ".flag(\"-I", ".flag(\"-p", ".flag(\"-u", ".link_argument"]);
    let lines: Vec<String> = lines.iter().map(|line| line.replace(&here, "/HERE/")).collect();
    assert_eq!(lines, [&flags[..], &linked[..]].concat());
    let image = emit_on(&plan, &all_on(&plan, "some_board"));
    let lines: Vec<String> = lines_with(&image, &["target_link_libraries", "target_compile_options(app PRIVATE [=[-l"])
        .iter()
        .map(|line| line.replace(&here, "/HERE/"))
        .collect();
    let linked = linked.map(|line| line.replace(".link_argument(\"", "target_link_libraries(app PRIVATE [=["));
    assert_eq!(lines, linked.map(|line| line.replace("\")", "]=])")));
}

#[test]
fn code_for_a_library_that_images_lack_is_refused_at_its_place() {
    for flag in ["-fsanitize=address", "-fopenmp", "--coverage"] {
        let text = format!("target C {{ compiler-flags: [\"-O2\",\n  \"{flag}\"] }}\nmain reactor {{ }}\n");
        let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text)])).plan.expect("it is right");
        emit_on(&plan, &Deployment::default());
        let deployment = all_on(&plan, "some_board");
        let errors = emit(&plan, &settings(&deployment)).expect_err("it cannot be linked");
        let told = format!("P.lf:2:3: error: `{flag}` needs a library that images do not have");
        assert!(errors[0].to_string().starts_with(&told), "{}", errors[0]);
    }
}

#[test]
fn cpp_of_banks_and_delays() {
    let (head, _) = TEXT.split_once("federated reactor").expect("it is there");
    let (_, inside) = TEXT.split_once("reactor Inside").expect("it is there");
    let text = format!("{head}main reactor{inside}").replacen("target C", "target CCpp", 1);
    let all = emitted(&text);
    let files = all.split("======== ").filter(|file| extension(file) == "cpp");
    insta::assert_snapshot!(files.collect::<Vec<_>>().join("======== "));
}

#[test]
fn headers_for_bodies_that_are_functions() {
    let all = emitted(FUNCTIONS);
    let files = all.split("======== ").filter(|file| {
        let is_of_reactors = file.starts_with("P/c/") && !file.starts_with("P/c/program.c");
        extension(file) == "h" || is_of_reactors
    });
    insta::assert_snapshot!(files.collect::<Vec<_>>().join("======== "));
}

/// Returns the extension of a file in a listing.
fn extension(file: &str) -> &str {
    file.lines().next().and_then(|name| name.rsplit_once('.')).map_or("", |(_, extension)| extension)
}

#[test]
fn c_of_a_federation() {
    insta::assert_snapshot!(emitted(TEXT));
}

#[test]
fn c_of_banks_and_delays() {
    let (head, _) = TEXT.split_once("federated reactor").expect("it is there");
    let (_, inside) = TEXT.split_once("reactor Inside").expect("it is there");
    insta::assert_snapshot!(emitted(&format!("{head}main reactor{inside}")));
}
