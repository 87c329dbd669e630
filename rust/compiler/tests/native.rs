// SPDX-License-Identifier: Apache-2.0
//! The plans of programs in C beyond those of all programs: files and macros, the names of contained reactors' ports in
//! bodies, and their widths.

use std::collections::BTreeMap;

use lf_compiler::plan::{Argument, ChildPort, Plan, ReactionKind, Value};
use lf_compiler::{Style, compile};

/// Returns the plan of the first of these files.
fn plan(files: &[(&str, &str)]) -> Plan {
    let texts: BTreeMap<String, String> =
        files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect();
    let compilation = compile(files[0].0, &texts);
    compilation.plan.unwrap_or_else(|| panic!("{}", compilation.diagnostics.render(Style::Plain)))
}

#[test]
fn files_and_macros_of_imported_files_count_and_say_whose_they_are() {
    let plan = plan(&[
        (
            "src/Main.lf",
            "target CCpp { files: [\"../c/a.c\", \"lib/b.h\"], cmake-include: \"all.cmake\",
               compiler-flags: \"-O2 -Wall\",
               compile-definitions: { LIMIT: 3, NAME: \"x\" }, build-type: Release, no-source-mapping: true }
             import Inner from \"lib/Inner.lf\"
             main reactor { inner = new Inner() }",
        ),
        (
            "src/lib/Inner.lf",
            "target C { compile-definitions: { LIMIT: 4 }, cmake-include: \"inner.cmake\", compiler: \"other\" }
             reactor Inner { }",
        ),
        ("src/all.cmake", "target_sources(${LF_MAIN_TARGET} PRIVATE a.c)"),
        ("src/lib/inner.cmake", "add_compile_definitions(INNER)\nfind_package(Inner)"),
        ("c/a.c", ""),
        ("src/lib/b.h", ""),
    ]);
    let c = &plan.target.c;
    assert!(c.is_cpp && c.no_lines);
    assert_eq!((plan.target.language.name(), c.compiler.as_deref()), ("C", None));
    assert_eq!(c.flags.iter().map(|flag| flag.text.as_str()).collect::<Vec<_>>(), ["-O2", "-Wall"]);
    assert_eq!(c.files.iter().map(|file| file.path.as_str()).collect::<Vec<_>>(), ["c/a.c", "src/lib/b.h"]);
    assert_eq!(
        c.cmake.iter().map(|file| file.path.as_str()).collect::<Vec<_>>(),
        ["src/all.cmake", "src/lib/inner.cmake"]
    );
    assert_eq!(plan.path(c.cmake[1].at), "src/lib/Inner.lf");
    let macros = c.definitions.iter().map(|it| (it.name.as_str(), it.value.as_str(), plan.path(it.at)));
    let expected = [("LIMIT", "3", "src/Main.lf"), ("NAME", "x", "src/Main.lf"), ("LIMIT", "4", "src/lib/Inner.lf")];
    assert_eq!(macros.collect::<Vec<_>>(), expected);
}

const BANKS: &str = "target C
reactor Inner(bank_index: int = 0, widths: int[] = {1, 2}) {
  mutable input[bank_index + 1] in: int*
  output out: int[3]
}
reactor Outer(n: int = {= 1 + 1 =}) {
  bank = new[{= self->n =}] Inner(bank_index = bank_index)
  single = new Inner()
  state list: int[](1, 2, 3)
  state one: int[](1)
  state text: string = \"\"\"a \"b\" c\"\"\"
  state late: time = -1 s
  reaction work(startup) bank.out, single.out -> bank.in, single.in
  reaction(single.out) {= =}
}
main reactor { outer = new Outer() }";

#[test]
fn variables_of_reactions_say_which_port_of_which_contained_reactor_they_are() {
    let plan = plan(&[("Main.lf", BANKS)]);
    let class = plan.classes.iter().find(|class| class.name == "Outer").expect("it is instantiated");
    let inner = plan.classes.iter().find(|class| class.name == "Inner").expect("it is instantiated");
    assert!(inner.ports[0].mutable && !inner.ports[1].mutable);
    assert_eq!([&inner.ports[0], &inner.ports[1]].map(|port| port.ty.text.as_str()), ["int*", "int[3]"]);
    let [work, other] = &class.reactions[..] else { panic!("there are two reactions") };
    assert!(work.external && !other.external);
    let named = work.parameters.iter().map(|it| (it.name.as_str(), it.child.clone().expect("it is of a child")));
    let of = |child: &str, is_bank, port: &str, is_wide| ChildPort {
        child: child.to_owned(),
        is_bank,
        port: port.to_owned(),
        is_wide,
    };
    let expected = [
        ("bank.out", of("bank", true, "out", false)),
        ("single.out", of("single", false, "out", false)),
        ("bank.in", of("bank", true, "in", true)),
        ("single.in", of("single", false, "in", true)),
    ];
    assert_eq!(named.collect::<Vec<_>>(), expected);
    let mut scheduled = plan.federates[0].reactions.iter();
    let arguments = scheduled.find_map(|reaction| match &reaction.kind {
        ReactionKind::Body { reaction: 1, arguments, .. } => Some(arguments),
        _ => None,
    });
    let [outs, out, ins, input] = &arguments.expect("it is scheduled")[..] else { panic!("there are four") };
    assert!(matches!(outs, Argument::Ports(ports) if ports.len() == 2));
    assert!(matches!(out, Argument::Port(_)));
    assert!(matches!(ins, Argument::Bank { ports, widths } if ports.len() == 3 && widths == &[1, 2]));
    assert!(matches!(input, Argument::Ports(ports) if ports.len() == 1));
}

#[test]
fn initial_values_are_those_of_c() {
    let plan = plan(&[("Main.lf", BANKS)]);
    let class = plan.classes.iter().find(|class| class.name == "Outer").expect("it is instantiated");
    let values = class.state.iter().map(|state| match &state.init {
        Some(Value::Code(code)) => code.text.as_str(),
        _ => "",
    });
    assert_eq!(values.collect::<Vec<_>>(), ["{1, 2, 3}", "{1}", "\"a \\\"b\\\" c\"", "((interval_t)-1000000000LL)"]);
}

/// The macros of an heir's file affect inherited code, unless both files define the same.
#[test]
fn a_macro_of_an_heir_in_inherited_code_is_a_warning() {
    let base = |own: &str| {
        format!(
            "target C\npreamble {{=\n#define LIMIT {own}\n=}}\n\
             reactor Base {{ reaction(startup) {{= int x = LIMIT; =}} }}"
        )
    };
    let heir = "target C\nimport Base from \"Base.lf\"\npreamble {=\n  # define LIMIT 5\n#define OTHER 1\n=}\n\
                reactor Heir extends Base { reaction(shutdown) {= int x = LIMIT + OTHER; =} }\nmain reactor { a = new \
                Heir() }";
    let warnings = |own: &str| {
        let files = BTreeMap::from([("Heir.lf".to_owned(), heir.to_owned()), ("Base.lf".to_owned(), base(own))]);
        let compilation = compile("Heir.lf", &files);
        assert!(compilation.plan.is_some());
        compilation.diagnostics.iter().map(|entry| (entry.code, entry.message.clone())).collect::<Vec<_>>()
    };
    let message = "`LIMIT` of this file takes part in code that `Heir` inherits".to_owned();
    assert_eq!(warnings("3"), [(lf_compiler::Code::InheritedMacro, message)]);
    assert_eq!(warnings("5"), []);
}
