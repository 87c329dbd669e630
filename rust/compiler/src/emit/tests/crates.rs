// SPDX-License-Identifier: Apache-2.0
//! The manifests of programs with crates and modules of their own.

use std::collections::BTreeMap;

use super::{all_on, emit_on};
use crate::compile;
use crate::deployment::Deployment;
use crate::plan::Plan;

const PROGRAM: &str = r#"
target Rust {
    cargo-features: ["filter", "thermo/half"],
    cargo-dependencies: {
        libm: "0.2",
        thermo: { path: "../thermo", default-features: false, features: ["a", "b"] },
        filter: { git: "https://example.org/filter", tag: "v1", optional: true, package: "fir-filter" },
    },
    rust-include: ["filters.rs", "/lib/units"],
    build-type: "relwithdebinfo",
    edition: "2021"
}
main reactor { reaction(startup) {= crate::filters::run(); =} }
"#;

#[test]
fn crates_and_modules_are_told_to_cargo() {
    let files = [("src/P.lf", PROGRAM), ("thermo/Cargo.toml", ""), ("src/filters.rs", ""), ("/lib/units/mod.rs", "")];
    let files: BTreeMap<String, String> = files.map(|(path, text)| (path.to_owned(), text.to_owned())).into();
    let compilation = compile("src/P.lf", &files);
    let said = compilation.diagnostics.render(crate::Style::Plain);
    let plan = compilation.plan.unwrap_or_else(|| panic!("{said}"));
    let mut text = said;
    for deployment in [Deployment::default(), all_on(&plan, "some_board")] {
        for file in emit_on(&plan, &deployment).files {
            if ["Cargo.toml", "lib.rs"].iter().any(|end| file.path.ends_with(end)) {
                text = text + "======== " + &file.path + "\n" + &file.text;
            }
        }
    }
    insta::assert_snapshot!(text);
}

/// Cargo accepts no crate twice.
#[test]
fn a_program_may_ask_for_the_crates_of_serde_itself() {
    let program = r#"
target Rust { cargo-dependencies: { serde: { version: "1.0.200", features: ["derive", "rc"] } } }
reactor A { @serializer("postcard") @max_length(9) output y: Vec<u8>  reaction(startup) -> y {= =} }
reactor B { input x: Vec<u8>  reaction(x) {= =} }
federated reactor { a = new A()  b = new B()  a.y -> b.x }
"#;
    let files: BTreeMap<String, String> = [("P.lf".to_owned(), program.to_owned())].into();
    let plan = compile("P.lf", &files).plan.expect("it is right");
    let emitted = emit_on(&plan, &Deployment::default());
    let manifest = emitted.files.iter().find(|file| file.path == "a/Cargo.toml").expect("it is emitted");
    let lines = |name: &str| manifest.text.lines().filter(|line| line.trim_matches('"').starts_with(name)).count();
    assert_eq!((lines("serde"), lines("postcard")), (1, 1), "{}", manifest.text);
    assert!(manifest.text.contains("1.0.200"), "{}", manifest.text);
}

/// The code for devices is compiled for programs that mention some; images always have it.
#[test]
fn devices_are_a_feature_of_programs_that_speak_of_them() {
    let manifest = |body: &str, deployment: &dyn Fn(&Plan) -> Deployment| {
        let program = format!("target Rust\nmain reactor {{ reaction(startup) {{= {body} =}} }}");
        let files: BTreeMap<String, String> = [("P.lf".to_owned(), program)].into();
        let plan = compile("P.lf", &files).plan.expect("it is right");
        let emitted = emit_on(&plan, &deployment(&plan));
        let manifest = emitted.files.into_iter().find(|file| file.text.contains("[package]"));
        manifest.expect("it is emitted").text
    };
    let host = |_: &Plan| Deployment::default();
    assert!(manifest("device!(led0).output().unwrap();", &host).contains("features = [\"devices\"]"));
    assert!(!manifest("println!();", &host).contains("devices"));
    assert!(!manifest("println!(\"devices\"); /* device!(led0) */", &host).contains("devices"));
    assert!(!manifest("let my_device = 1;", &host).contains("devices"));
    let method = "=} method of(pin: {= lf::devices::Pin =}) {=";
    assert!(manifest(method, &host).contains("features = [\"devices\"]"));
    let image = |plan: &Plan| all_on(plan, "some_board");
    assert!(!manifest("device!(led0).output().unwrap();", &image).contains("devices"));
}
