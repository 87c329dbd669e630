// SPDX-License-Identifier: Apache-2.0
//! C beside bodies in Rust: the files of each participant, and their configuration for cargo and for Zephyr's build.

use std::collections::BTreeMap;

use super::{all_on, emit_on};
use crate::compile;
use crate::deployment::Deployment;
use crate::plan::Plan;

const FILES: [(&str, &str); 11] = [
    (
        "src/Main.lf",
        "target Rust { timeout: 1 s }
import Fan from \"Fan.lf\"
import Plain from \"Plain.lf\"
import InC from \"InC.lf\"
federated reactor { fan = new Fan()  plain = new Plain()  in_c = new InC()  (fan.speed)+ -> plain.speed, in_c.speed }",
    ),
    (
        "src/Fan.lf",
        "target Rust {
    c-sources: [\"../driver/fan.c\", \"/vendor/pwm.c\"],
    c-headers: \"../driver/fan.h\",
    c-include-directories: \"/vendor/include\",
    compile-definitions: { STEP: 5 },
    cmake-include: \"fan.cmake\",
}
preamble {= pub struct Speed(c::fan_speed); =}
reactor Fan { output speed: u32  reaction(startup) -> speed {= ctx.set(speed, c::STEPS); =} }",
    ),
    ("src/Plain.lf", "target Rust\nreactor Plain { input speed: u32  reaction(speed) {= =} }"),
    (
        "src/InC.lf",
        "target C { files: \"in_c.h\", compile-definitions: { LIMIT: 3 } }
reactor InC { input speed: uint32_t  reaction(speed) {= =} }",
    ),
    ("src/in_c.h", ""),
    ("src/fan.cmake", "target_link_libraries(${LF_MAIN_TARGET} m)\n"),
    ("driver/fan.c", ""),
    ("driver/fan.h", ""),
    ("/vendor/pwm.c", ""),
    ("/vendor/include", ""),
    ("/vendor/include/pwm.h", ""),
];

fn plan(files: &[(&str, &str)]) -> Result<Plan, String> {
    let texts: BTreeMap<String, String> =
        files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect();
    let compilation = compile(files[0].0, &texts);
    let said = compilation.diagnostics.render(crate::Style::Plain);
    compilation.plan.filter(|_| said.is_empty()).ok_or(said)
}

#[test]
fn only_federates_whose_file_asks_for_c_get_it() {
    let plan = plan(&FILES).unwrap_or_else(|said| panic!("{said}"));
    let mut text = String::new();
    for deployment in [Deployment::default(), all_on(&plan, "some_board")] {
        for file in emit_on(&plan, &deployment).files {
            let is_of_fan = file.path.starts_with("fan/") && !file.path.ends_with("federate.rs");
            let names = ["build.rs", "c.cmake", "program.cmake", "plain/Cargo.toml", "plain/src/plain/mod.rs"];
            if (is_of_fan && !file.path.ends_with("main.rs")) || names.iter().any(|name| file.path.ends_with(name)) {
                text = text + "======== " + &file.path + "\n" + &file.text;
            }
        }
    }
    insta::assert_snapshot!(text);
}

/// The RTI runs no reactions of the program, but it has the preambles that declare payloads.
#[test]
fn an_rti_alone_has_headers_and_no_sources() {
    let program = "target Rust { c-sources: \"a.c\", c-headers: \"a.h\", cmake-include: \"a.cmake\" }
preamble {=
    #[derive(Clone, Copy, Payload)] pub struct Value(pub u32);
    impl From<c::value> for Value { fn from(value: c::value) -> Self { Self(value.number) } }
=}
reactor A { output y: Value  reaction(startup) -> y {= =} }
reactor B { input x: Value  reaction(x) {= =} }
federated reactor { a = new A()  b = new B()  a.y -> b.x }";
    let plan = plan(&[("Main.lf", program), ("a.c", ""), ("a.h", ""), ("a.cmake", "")]);
    let plan = plan.unwrap_or_else(|said| panic!("{said}"));
    let text = "rti: { platform: some_board, ip: 10.0.0.1 }\n\
                federates:\n  a: { platform: some_board, ip: 10.0.0.2 }\n  b: { platform: some_board, ip: 10.0.0.3 }\n";
    let deployment = Deployment::parse("deployment.yaml", text, &plan).expect("it is right");
    let emitted = emit_on(&plan, &deployment);
    let file = |path: &str| emitted.files.iter().find(|file| file.path == path).map(|file| file.text.as_str());
    let (rti, federate) = (file("rti/c.cmake").expect("it has some"), file("a/c.cmake").expect("it has some"));
    assert!(rti.contains("set(bindings TRUE)") && federate.contains("set(bindings TRUE)"));
    assert!(federate.contains("a.c]=") && federate.contains("a.cmake"), "{federate}");
    assert!(!rti.contains("a.c]=") && !rti.contains("a.cmake"), "{rti}");
}

#[test]
fn wrong_files_are_errors_at_their_names() {
    let program = "target Rust {
    c-sources: [\"missing.c\", \"a.h\", 3],
    c-headers: { a: \"a.h\" },
    c-include-directories: \"nowhere\",
    files: \"a.h\",
    rust-include: \"c.rs\",
}
main reactor { }";
    let said = plan(&[("Main.lf", program), ("a.h", ""), ("c.rs", "")]).expect_err("it is wrong");
    let of_c = plan(&[("Main.lf", "target C { c-sources: \"a.c\" }\nmain reactor { }"), ("a.c", "")]);
    insta::assert_snapshot!(said + &of_c.expect_err("it is wrong"));
}
