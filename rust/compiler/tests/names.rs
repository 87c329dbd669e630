// SPDX-License-Identifier: Apache-2.0
//! The meanings of names, in correct and in incorrect programs.

use std::collections::BTreeMap;

use lf_compiler::{Declaration, NameKind, ResolvedNames, compile, names, parse};
use proptest::prelude::*;

const LIBRARY: &str = "target Rust
// The common part.
reactor Base(period: time = 10 ms) {
  /* The value
   * that comes. */
  input x: u8
  output y: u32
}
reactor Holder<T>(
  first: T,
  // The period.
  period: time
) { input x: T  output y: T }
";

const MAIN: &str = "target Rust
import Base as Basis, Holder from \"lib.lf\"
reactor Unit(limit: u32 = 3) extends Basis {
  // The count.
  // Not reset.
  state seen: u32 = limit
  timer t(0, period)
  logical action again(1 ms): u32
  initial mode On {
    reaction count(t, x) -> again, reset(Off) {= self.seen += ctx.get(x).unwrap(); ctx.set_mode(Off) =}
      deadline(period) {= ctx.schedule(again, Asap) =}
  }
  mode Off { watchdog late(period) -> y {= =} }
}
main reactor(n: usize = 2) {
  @label(\"a\")
  unit = new[n] Unit(limit = n)
  other = new Holder<u32>(first = n, period = 1 s)
  unit.y -> other.x after 5 ms
  reaction(other.y) -> unit.x {= let other__y = ctx.get(other__y); format!(\"{other__y:?} {unit__x} x\"); =}
}
";

fn files(main: &str) -> BTreeMap<String, String> {
    [("main.lf", main), ("lib.lf", LIBRARY)].map(|(path, text)| (path.to_owned(), text.to_owned())).into()
}

/// Returns all names as lines: the place and the meaning of each.
fn listing(names: &ResolvedNames) -> String {
    let place = |span: lf_compiler::diagnostics::Span| {
        let file = names.sources().get(span.file).expect("the text is there");
        let position = file.position(span.start);
        format!("{}:{}:{} `{}`", file.path(), position.line, position.column, names.sources().slice(span))
    };
    let line = |(span, declaration): (_, &Declaration)| {
        let declared = if declaration.span == span { "declares".to_owned() } else { place(declaration.span) };
        let ty = declaration.ty.as_ref().map(|ty| format!(": {ty}")).unwrap_or_default();
        let docs = declaration.docs.as_ref().map(|docs| format!(" // {docs:?}")).unwrap_or_default();
        format!("{} = {declared}, {:?}{ty}{docs}\n", place(span), declaration.kind)
    };
    names.iter().map(line).collect()
}

#[test]
fn each_name_means_what_declares_it() {
    insta::assert_snapshot!(listing(&names("main.lf", &files(MAIN))));
}

/// In a program with errors, all readable names keep their meanings.
#[test]
fn names_in_a_wrong_program_have_their_meaning() {
    let wrong = MAIN
        .replace("state seen: u32 = limit", "state seen: u32 = limit\n  state = = ;")
        .replace("unit.y -> other.x", "unit.nothing -> other.x");
    assert!(compile("main.lf", &files(&wrong)).plan.is_none());
    let all = names("main.lf", &files(&wrong));
    let meant = |word: &str, kind: NameKind| {
        let count = all.iter().filter(|(span, it)| all.sources().slice(*span) == word && it.kind == kind).count();
        assert!(count >= 2, "{word} is named {count} times:\n{}", listing(&all));
    };
    meant("limit", NameKind::Parameter);
    meant("other", NameKind::Instance);
    meant("Unit", NameKind::Reactor);
    meant("Off", NameKind::Mode);
    assert!(all.iter().all(|(span, _)| all.sources().slice(span) != "nothing"));
}

#[test]
fn a_name_is_found_at_each_of_its_bytes_and_behind_the_last() {
    let all = names("main.lf", &files(MAIN));
    let (span, declaration) = all.iter().find(|(span, _)| all.sources().slice(*span) == "seen").expect("it is there");
    for byte in span.start..=span.end {
        assert_eq!(all.at(span.file, byte), Some((span, declaration)));
    }
    assert_eq!(all.at(span.file, span.end + 1), None);
    assert_eq!(all.at(span.file, 0), None);
    let limit = all.iter().find(|(_, it)| it.kind == NameKind::Parameter).expect("there is one").1.span;
    assert!(all.places_of(limit).count() > 1);
}

#[test]
fn the_tree_of_a_broken_file_has_the_rest_and_all_errors() {
    let tree = parse("broken.lf", "target Rust\nreactor A { input x: = }\nreactor B { reaction(startup) {= ( =} }\n");
    let names: Vec<_> =
        tree.unit.reactors.iter().filter_map(|reactor| Some(reactor.name.as_ref()?.text.as_str())).collect();
    assert_eq!(names, ["A", "B"]);
    assert_eq!(tree.diagnostics.iter().count(), 2, "{}", tree.diagnostics.render(lf_compiler::Style::Plain));
}

#[test]
fn a_program_that_is_not_there_has_no_names() {
    assert_eq!(names("nowhere.lf", &files(MAIN)).iter().count(), 0);
}

proptest! {
    #[test]
    fn any_text_has_a_tree_and_names(
        text in ".{0,200}", at in any::<prop::sample::Index>(), length in 0_usize..30,
    ) {
        let mut main: Vec<char> = MAIN.chars().collect();
        let at = at.index(main.len());
        let end = (at + length).min(main.len());
        main.splice(at..end, text.chars());
        let main: String = main.into_iter().collect();
        parse("main.lf", &main);
        let all = names("main.lf", &files(&main));
        for (span, declaration) in all.iter() {
            prop_assert!(!all.sources().slice(span).is_empty());
            prop_assert!(!all.sources().slice(declaration.span).is_empty());
        }
    }
}
