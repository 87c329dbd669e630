// SPDX-License-Identifier: Apache-2.0
//! The code that shares the reactions of a level among several threads.

use std::collections::BTreeMap;

use super::{all_on, emit_on};
use crate::compile;
use crate::deployment::Deployment;

const PROGRAM: &str = r"
target Rust { workers: 3 }
reactor Source { output y: String  reaction(startup) -> y {= =} }
reactor Filter {
  input x: String
  output y: u8
  logical action again: u8
  state seen: Vec<u32>
  initial mode One { reaction(x) -> y, again {= =} deadline(5 ms) {= =} }
  mode Two { reaction(x) -> y, reset(One) {= =} }
}
reactor Sink { input[2] x: u8  reaction(x) {= =} }
main reactor {
  source = new Source()
  filters = new[2] Filter()
  sink = new Sink()
  (source.y)+ -> filters.x
  filters.y -> sink.x
}
";

/// The output has tables, the shared levels, and the bounds of types; an image has none of that.
#[test]
fn the_reactions_of_a_level_are_lent_with_what_they_use() {
    let files: BTreeMap<String, String> = [("P.lf".to_owned(), PROGRAM.to_owned())].into();
    let plan = compile("P.lf", &files).plan.expect("it is right");
    let emitted = emit_on(&plan, &Deployment::default());
    let text = |path: &str| {
        let file = emitted.files.iter().find(|file| file.path.ends_with(path)).expect("it is emitted");
        file.text.as_str()
    };
    let between = |text: &str, begin: &str, end: &str| {
        let from = text.find(begin).unwrap_or_else(|| panic!("{begin} in {text}"));
        let length = text[from..].find(end).unwrap_or_else(|| panic!("{end} in {text}")) + end.len();
        text[from..from + length].to_owned()
    };
    let shown = [
        between(text("P/Cargo.toml"), "[dependencies]", "}"),
        between(text("federate.rs"), "    workers: ", "};"),
        between(text("federate.rs"), "    fn share(", "\n    }\n"),
        between(text("filter.rs"), "const _", "/// An instance"),
    ];
    insta::assert_snapshot!(shown.join("\n...\n"));
    let image = emit_on(&plan, &all_on(&plan, "some_board"));
    let mentions = |word: &str| image.files.iter().any(|file| file.text.contains(word));
    assert!(!mentions("Workers") && !mentions("fn share") && !mentions("moves_between_threads"));
}

/// In C a job has the actions and watchdogs of its reactor, and ports are C's.
#[test]
fn a_job_in_c_is_lent_the_actions_of_its_reactor() {
    let program = r"
target C { workers: 2 }
reactor Member {
  input x: int
  output y: int
  logical action again
  physical action outside: int
  watchdog late(5 ms) {= =}
  reaction(x) -> y, again, late {= =} deadline(5 ms) {= =}
}
main reactor {
  timer t(0)
  members = new[2] Member()
  reaction(t) -> members.x {= =}
}
";
    let files: BTreeMap<String, String> = [("P.lf".to_owned(), program.to_owned())].into();
    let plan = compile("P.lf", &files).plan.expect("it is right");
    let emitted = emit_on(&plan, &Deployment::default());
    let file = emitted.files.iter().find(|file| file.path.ends_with("federate.rs")).expect("it is emitted");
    let (_, share) = file.text.split_once("    fn share(").expect("there are levels to share");
    let (share, _) = share.split_once("\n    }\n").expect("the method ends");
    insta::assert_snapshot!(share);
}
