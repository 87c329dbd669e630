// SPDX-License-Identifier: Apache-2.0
//! What cargo is told about programs with crates and modules of their own.

use std::collections::BTreeMap;

use super::emit_on;
use crate::compile;
use crate::deployment::{Deployment, Platform};

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
    for deployment in [Deployment::default(), Deployment::all_on(&plan, &Platform::Zephyr("some_board".to_owned()))] {
        for file in emit_on(&plan, &deployment).files {
            if ["Cargo.toml", "lib.rs"].iter().any(|end| file.path.ends_with(end)) {
                text = text + "======== " + &file.path + "\n" + &file.text;
            }
        }
    }
    insta::assert_snapshot!(text);
}
