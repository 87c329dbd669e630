// SPDX-License-Identifier: Apache-2.0
//! Programs as people write them for LF's own compilers: they have a plan, and what has no effect is a warning.

use std::collections::BTreeMap;

use lf_compiler::plan::{Coordination, Plan, TriggerKind};
use lf_compiler::{Compilation, Style, compile};

fn compiled(files: &[(&str, &str)]) -> Compilation {
    let texts: BTreeMap<String, String> =
        files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect();
    compile(files[0].0, &texts)
}

/// Returns the plan of the first of these files, and the first lines of all warnings.
fn plan(files: &[(&str, &str)]) -> (Plan, String) {
    let compilation = compiled(files);
    let said = compilation.diagnostics.render(Style::Plain);
    let plan = compilation.plan.unwrap_or_else(|| panic!("{said}"));
    let warnings: Vec<_> = said.lines().filter(|line| line.contains(" warning[")).collect();
    (plan, warnings.join("\n"))
}

#[test]
fn properties_without_an_effect_and_old_names_are_warnings() {
    let (plan, warnings) = plan(&[(
        "Main.lf",
        r#"target C {
  Timeout: 3 sec, Build-Type: release, build: "./build.sh", docker: true, no-compile: true, cmake: true,
  scheduler: { type: STATIC, mapper: LB }, trace-plugin: { package: p }, flags: "-O1", comm-type: TCP
}
main realtime reactor { reaction() {= =} @wcet("5 ms") reaction(startup) {= =} }"#,
    )]);
    assert_eq!(plan.target.timeout_ns, Some(3_000_000_000));
    assert_eq!(plan.target.c.flags[0].text, "-O1");
    insta::assert_snapshot!(warnings);
}

#[test]
fn attributes_of_the_main_reactor_are_target_properties() {
    let (with_attributes, warnings) = plan(&[(
        "Main.lf",
        "target C\n@timeout(5s)\n@fast(true)\n@logging(\"DEBUG\")\n@build_type(\"Release\")\n@keepalive(true)\n\
         @platform(\"native\")\nmain reactor { reaction(startup) {= =} }",
    )]);
    let (with_properties, _) = plan(&[(
        "Main.lf",
        "target C {\n timeout: 5s,\n fast: true, logging: debug,\n build-type: Release, keepalive: true,\n\
         platform: Native }\n\nmain reactor { reaction(startup) {= =} }",
    )]);
    assert_eq!(
        (format!("{:?}", with_attributes.target), warnings.as_str()),
        (format!("{:?}", with_properties.target), "")
    );

    let said = compiled(&[(
        "Main.lf",
        "target C { timeout: 1 s }\n@timeout(5s)\nmain reactor { @fast(true) a = new A() }\n\
         @logging(\"loud\") reactor A { }",
    )]);
    insta::assert_snapshot!(said.diagnostics.render(Style::Plain));
}

#[test]
fn inherited_connections_and_reactions_may_be_repeated() {
    let (plan, warnings) = plan(&[(
        "Main.lf",
        "target C
reactor Inner { input in: int output out: int32_t reaction first(in) -> out {= lf_set(out, 1); =} }
reactor Base { output y: int input x: int i = new Inner() x -> i.in i.out -> y reaction go(startup) {= =} }
reactor Derived extends Base { i.out -> y reaction go(startup) {= =} }
main reactor { d = new Derived() }",
    )]);
    let derived = plan.classes.iter().find(|class| class.name == "Derived").expect("it is used");
    assert_eq!((derived.reactions.len(), warnings.as_str()), (2, ""));
}

#[test]
fn files_that_import_each_other_are_one_program() {
    let (plan, _) = plan(&[
        ("Main.lf", "target C\nimport A from \"A.lf\"\nmain reactor { a = new A() }"),
        ("A.lf", "target C\nimport B from \"B.lf\"\nreactor A { b = new B() }\nreactor Small { }"),
        ("B.lf", "target C\nimport Small from \"A.lf\"\nreactor B { s = new Small() }"),
    ]);
    assert_eq!(plan.classes.len(), 4);
}

#[test]
fn files_of_the_library_are_known() {
    let (plan, warnings) = plan(&[(
        "Main.lf",
        r#"target C {
  files: ["/lib/c/reactor-c/util/deque.c", "/lib/c/reactor-c/util/deque.h", "/lib/c/reactor-c/util/audio_loop_mac.c"],
  cmake-include: ["/lib/c/reactor-c/util/deque.cmake"]
}
main reactor { reaction(startup) {= =} }"#,
    )]);
    assert_eq!((plan.target.c.files.len(), plan.target.c.cmake.len()), (2, 1));
    insta::assert_snapshot!(warnings);
}

#[test]
fn programs_of_micro_lf_need_no_target_and_decide_for_themselves() {
    let (plan, warnings) = plan(&[(
        "Main.ulf",
        "reactor R(bank_idx: int = 0) {
  input in: int
  @max_pending_events(7) logical action a(0, 0, \"drop\"): int
  reaction(startup, in) -> a {= validate(self->bank_idx < 2); lf_schedule(a, MSEC(1), 3); =}
}
reactor S { output out: int reaction(startup) -> out {= lf_set(out, 1); =} }
@platform(\"native\")
federated reactor { s = new S() r = new[2] R() @link(left=\"if1\", right=\"if1\") @buffer(9) (s.out)+ -> r.in }",
    )]);
    assert!(plan.target.c.is_micro && plan.target.coordination == Coordination::Decentralized);
    let triggers = plan.federates.iter().flat_map(|federate| &federate.triggers);
    let spacing = triggers.filter_map(|trigger| match &trigger.kind {
        TriggerKind::Action { min_spacing_ns, .. } => Some(*min_spacing_ns),
        _ => None,
    });
    assert_eq!(spacing.collect::<Vec<_>>(), [Some(1), Some(1)]);
    let waits = plan.federates.iter().flat_map(|federate| &federate.inputs).map(|input| input.max_wait_ns);
    assert_eq!(waits.collect::<Vec<_>>(), [0, 0]);
    insta::assert_snapshot!(warnings);
}
