// SPDX-License-Identifier: Apache-2.0
//! The places of each line of emitted code in the program, column by column.

use std::collections::BTreeMap;
use std::path::Path;

use super::{emit_on, fixture, rust_files};
use crate::compile;
use crate::deployment::Deployment;
use crate::emit::{Emitted, File};

/// Preambles, methods, modes, watchdogs, type parameters, inherited code and values that span lines.
const RUST: &str = r#"target Rust
preamble {= use core::cmp::max;
    struct Hidden(u32);
    pub(crate) enum Known { First } =}
reactor Base(first: u32 = {= 3 +
    4 =}) {
  preamble {=
    const LIMIT: u32 = 7;
  =}
  input x: Hidden
  output y: u32
  state sum: u32 = {= max(first,
      LIMIT) // behind it
  =}
  method bounded(value: u32, by: {= &Option<u32> =}): u32 {=
    value.min(by.unwrap_or(self.sum)) =}
  const method shown() {= println!("π {}", self.sum); =}
  @label("first")
  reaction(x) -> y {= ctx.set(y, self.bounded(1, &None)); =} deadline(1 msec) {= let late = (); =}
}
reactor Modal(wait: time = 5 msec) extends Base {
  initial mode On {
    reset state count: u32 = 1
    timer t(0, wait)
    reaction(t) -> reset(Off) {= self.count += 1; ctx.set_mode(Off); =}
  }
  mode Off {
    watchdog silence(2 msec) -> On {=
      ctx.set_mode(On);
    =}
    reaction(reset) -> silence {= ctx.start_watchdog(silence, delay!(0)); =}
  }
}
reactor Keep<T>(value: T) { state kept: T = value  reaction(startup) {= let _ = &self.kept; =} }
main reactor {
  m = new[2] Modal(first = {= bank_index as u32 =})
  k = new Keep<{= Option<Known> =}>(value = {= None =})
}
"#;

/// The same for C, with functions and loops that span lines.
const C: &str = r"target C
preamble {=
    #include <math.h>
    typedef struct { int a; } pair_t;
=}
reactor Base(first: int = {= 3 +
    4 =}, list: int[] = {1, 2}) {
  preamble {= #define LIMIT 7 =}
  input x: pair_t
  output y: int
  state sum: int = {= LIMIT
      + first =}
  method bounded(value: int): int {=
    return value < self->sum ? value : self->sum; =}
  reaction(x) -> y {= lf_set(y, bounded(1)); =} deadline(1 msec) {= int late = 0; (void)late; =}
}
reactor Modal(wait: time = 5 msec) extends Base {
  initial mode On {
    reset state count: int = 1
    timer t(0, wait)
    reaction(t) -> reset(Off) {= self->count += 1; lf_set_mode(Off); =}
  }
  mode Off {
    watchdog silence(2 msec) -> On {=
      lf_set_mode(On);
    =}
    reaction(reset) -> silence {= lf_watchdog_start(silence, 0); =}
  }
}
main reactor { m = new[2] Modal(first = {= bank_index =}) }
";

fn emitted(text: &str) -> Emitted {
    let compilation = compile("src/P.lf", &BTreeMap::from([("src/P.lf".to_owned(), text.to_owned())]));
    let said = compilation.diagnostics.render(crate::Style::Plain);
    emit_on(&compilation.plan.unwrap_or_else(|| panic!("{said}")), &Deployment::default())
}

/// Returns the pieces of a line of Rust that belong to the program, and the origin of the rest.
fn pieces(emitted: &Emitted, file: &File, line: usize, text: &str) -> String {
    let (map, path, count) = (&emitted.source_map, &file.path, text.chars().count());
    let place = |column: usize| map.to_lf(path, line, column).map(|(_, line, column)| (line, column));
    let follows = |one: Option<(usize, usize)>, other: Option<(usize, usize)>| {
        one.zip(other).is_some_and(|((line, column), next)| next == (line, column + 1))
    };
    let mut shown = String::new();
    let mut before = None;
    for column in 1..=count + 1 {
        let verbatim = map.is_verbatim(path, line, column);
        let here = place(column);
        if verbatim && !follows(before, here) {
            let (lf_line, lf_column) = here.unwrap_or_default();
            shown = format!("{shown} {column}={lf_line}:{lf_column}");
        } else if !verbatim && before.is_some() {
            shown = format!("{shown} {column}=.");
        }
        before = here.filter(|_| verbatim);
    }
    let scaffolding = (1..=count + 1).find(|column| !map.is_verbatim(path, line, *column)).and_then(place);
    scaffolding.map_or(shown.clone(), |(line, column)| format!("{shown} from {line}:{column}"))
}

/// Returns all lines of Rust that have an origin in the program.
fn of_rust(emitted: &Emitted) -> String {
    let mut text = String::new();
    for file in rust_files(emitted) {
        for (index, line) in file.text.lines().enumerate() {
            let shown = pieces(emitted, file, index + 1, line);
            if !shown.is_empty() {
                text = format!("{text}{}:{}{shown} | {}\n", file.path, index + 1, line.trim());
            }
        }
    }
    text
}

/// Returns all lines of C that `#line` maps to the program, with the places where they begin there.
fn of_c(emitted: &Emitted) -> String {
    let is_c =
        |file: &&File| Path::new(&file.path).extension().is_some_and(|it| ["c", "h", "cpp"].iter().any(|c| it == *c));
    let mut text = String::new();
    for file in emitted.files.iter().filter(is_c) {
        let mut told = None;
        for (index, line) in file.text.lines().enumerate() {
            if let Some((number, path)) = line.strip_prefix("#line ").and_then(|rest| rest.split_once(' ')) {
                let number: usize = number.parse().expect("it is a number");
                let is_own = !path.contains(".lf");
                assert!(!is_own || number == index + 2, "{}:{}: {line}", file.path, index + 1);
                told = Some(number).filter(|_| !is_own);
            } else if let Some(number) = told.as_mut() {
                let column = line.len() - line.trim_start().len() + 1;
                text = format!("{text}{}:{} {number}:{column} | {}\n", file.path, index + 1, line.trim());
                *number += 1;
            }
        }
    }
    text
}

#[test]
fn rust_of_all_kinds_of_code_is_mapped_to_the_program() {
    insta::assert_snapshot!(of_rust(&emitted(RUST)));
}

#[test]
fn rust_of_a_federation_is_mapped_to_the_program() {
    insta::assert_snapshot!(of_rust(&emit_on(&fixture::plan(), &Deployment::default())));
}

#[test]
fn c_is_mapped_to_the_program() {
    insta::assert_snapshot!(of_c(&emitted(C)));
}

#[test]
fn cpp_is_mapped_to_the_program() {
    insta::assert_snapshot!(of_c(&emitted(&C.replacen("target C", "target CCpp", 1))));
}
