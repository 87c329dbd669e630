// SPDX-License-Identifier: Apache-2.0
//! Programs with crates and modules of their own.

use std::fs;

use crate::support::{folder, lfz, said, text, write};

const PROGRAM: &str = r#"
target Rust {
    cargo-dependencies: {
        log: "0.4",
        thermo: { path: "crates/thermo", features: ["half"], default-features: false },
        never: { path: "crates/thermo", package: "thermo", optional: true },
    },
    cargo-features: ["cli", "thermo/double"],
    rust-include: ["filters.rs", "units"],
    build-type: Test,
    edition: "2018",
}

main reactor(size: u32 = 4) {
    reaction(startup) {=
        use crate::{filters::least, thermo::FEATURES};
        log::debug!("not shown");
        println!("{} {}", least(self.size, 2), crate::units::scale::KILO);
        println!("{:?} {} {}", thermo::FEATURES, FEATURES == thermo::FEATURES, cfg!(debug_assertions));
    =}
}
"#;

const FILES: [(&str, &str); 6] = [
    ("P.lf", PROGRAM),
    ("filters.rs", "pub fn least(a: u32, b: u32) -> u32 {\n    a.min(b)\n}\n"),
    ("units/mod.rs", "pub mod scale;\n"),
    ("units/scale.rs", "pub const KILO: u32 = 1000;\n"),
    (
        "crates/thermo/src/lib.rs",
        "#![no_std]\npub const FEATURES: [bool; 3] = [cfg!(feature = \"half\"), \
      cfg!(feature = \"double\"), cfg!(feature = \"whole\")];\n",
    ),
    (
        "crates/thermo/Cargo.toml",
        "[package]\nname = \"thermo\"\nversion = \"0.1.0\"\nedition = \"2021\"\n\n[features]\n\
      default = [\"whole\"]\nhalf = []\ndouble = []\nwhole = []\n",
    ),
];

#[test]
fn bodies_use_crates_and_modules_beside_the_program() {
    let folder = folder(&FILES);
    let output = said(&mut lfz(folder.path(), &["run"]));
    let errors = text(&output.stderr);
    assert_eq!(text(&output.stdout), "2 1000\n[true, true, false] true true\n", "{errors}");
    let lock = fs::read_to_string(folder.path().join("P.lf.lock")).expect("the versions are kept");
    assert!(lock.contains("name = \"log\"") && !lock.contains("thermo") && !lock.contains("name = \"p\""), "{lock}");

    // Another folder gets the same versions.
    fs::remove_dir_all(folder.path().join("out")).expect("it was generated");
    let output = said(&mut lfz(folder.path(), &["check", "--bodies"]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(folder.path().join("P.lf.lock")).expect("it is there"), lock);
}

#[test]
fn errors_in_included_files_are_at_their_places_in_them() {
    let folder = folder(&FILES);
    write(folder.path(), "units/scale.rs", "pub const KILO: u32 = 1000;\npub const MEGA: u32 = \"1\";\n");
    let output = said(&mut lfz(folder.path(), &["check", "--bodies"]));
    let errors = text(&output.stderr);
    assert!(errors.contains("units/scale.rs:2:23: error[E0308]: mismatched types\n"), "{errors}");
    assert!(errors.contains("2 | pub const MEGA: u32 = \"1\";"), "{errors}");
}

#[test]
fn messages_of_cargo_are_passed_on_once() {
    let folder = folder(&FILES);
    write(folder.path(), "P.lf", &PROGRAM.replace("log: \"0.4\"", "log: \"999\""));
    let output = said(&mut lfz(folder.path(), &["check", "--bodies"]));
    let errors = text(&output.stderr);
    assert!(!output.status.success());
    assert_eq!(errors.matches("error: ").count(), 1, "{errors}");
    assert!(errors.contains("log = \"^999\""), "{errors}");
    assert!(!folder.path().join("P.lf.lock").exists(), "nothing was chosen");
}
