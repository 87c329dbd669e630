// SPDX-License-Identifier: Apache-2.0
//! The emitted files, and their map to the program.

mod applications;
mod bodies_in_c;
mod c_beside;
mod crates;
mod deployments;
mod fixture;
mod source_maps;
mod workers;

use std::collections::BTreeMap;
use std::path::Path;

use super::{EmitError, Emitted, File, Settings, emit};
use crate::compile;
use crate::deployment::{Deployment, Place, Platform};
use crate::plan::{Plan, ReactorClass, Value};

fn settings(deployment: &Deployment) -> Settings<'_> {
    Settings { crates: "../../rust", version: "0.0.0", current: "/work", deployment, keys: "/keys" }
}

/// Returns a deployment of all federates on boards of this name.
fn all_on(plan: &Plan, board: &str) -> Deployment {
    let place = || Place { platform: Platform::Zephyr(board.to_owned()), ..Place::default() };
    let federates = plan.federates.iter().map(|federate| (federate.name.clone(), place())).collect();
    Deployment { federates, ..Deployment::default() }
}

fn emit_on(plan: &Plan, deployment: &Deployment) -> Emitted {
    emit(plan, &settings(deployment)).expect("the plan can be emitted")
}

fn refused(plan: &Plan) -> Vec<EmitError> {
    emit(plan, &settings(&Deployment::default())).expect_err("it is wrong")
}

fn class<'p>(plan: &'p mut Plan, name: &str) -> &'p mut ReactorClass {
    plan.classes.iter_mut().find(|class| class.name == name).expect("the fixture has it")
}

/// Returns all files as one text.
fn listing(emitted: &Emitted) -> String {
    let mut text = String::new();
    for file in &emitted.files {
        text = text + "======== " + &file.path + "\n" + &file.text;
    }
    text
}

fn rust_files(emitted: &Emitted) -> impl Iterator<Item = &File> {
    emitted.files.iter().filter(|file| Path::new(&file.path).extension().is_some_and(|extension| extension == "rs"))
}

/// Returns a deployment of the fixture with one board.
fn mixed(plan: &Plan) -> Deployment {
    let text = "rti: { ip: 10.0.0.1, port: 15099 }\n\
                federates:\n  unit: { platform: qemu_cortex_m3, ip: 10.0.0.2, gateway: 10.0.0.1, \
                mac: 02-00-00-00-00-0A }\n";
    Deployment::parse("deployment.yaml", text, plan).expect("it is right")
}

#[test]
fn the_plan_is_shown_to_people() {
    insta::assert_snapshot!("plan", fixture::plan());
}

#[test]
fn a_plan_survives_json() {
    let plan = fixture::plan();
    let json = serde_json::to_string(&plan).expect("it is plain data");
    assert_eq!(serde_json::from_str::<Plan>(&json).expect("it is plain data"), plan);
}

#[test]
fn values_that_need_a_heap_are_refused_for_images_and_for_an_rti_that_forwards_them() {
    let text = "target Rust
reactor A { @max_length(9) output x: String  @max_length(7) output y: {= Vec<u8> =}  reaction(startup) -> x, y {= =} }
reactor B { input x: String  input y: {= Vec<u8> =}  reaction(x, y) {= =} }
federated reactor { a = new A()  b = new B()  a.x, a.y -> b.x, b.y }
";
    let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text.to_owned())])).plan.expect("it is right");
    let errors = |place: &str| {
        let deployment = Deployment::parse("deployment.yaml", place, &plan).expect("it is right");
        emit(&plan, &settings(&deployment))
            .map_or_else(|errors| errors.iter().map(ToString::to_string).collect(), |_| Vec::new())
    };
    assert_eq!(errors("{}"), Vec::<String>::new());
    insta::assert_debug_snapshot!(
        "heap",
        [
            errors("rti: { ip: 10.0.0.1 }\nfederates: { b: { platform: qemu_cortex_m3, ip: 10.0.0.2 } }"),
            errors("rti: { platform: qemu_cortex_m3, ip: 10.0.0.2 }"),
        ]
    );
}

#[test]
fn states_that_need_a_heap_are_refused_for_an_rti_in_an_image_that_passes_them_on() {
    let text = "target Rust
reactor A { @handed_over @max_length(9) state x: String  timer t  reaction(t) {= =} }
reactor B { timer t  reaction(t) {= =} }
federated reactor { @transient a = new A()  b = new B() }
";
    let plan = compile("P.lf", &BTreeMap::from([("P.lf".to_owned(), text.to_owned())])).plan.expect("it is right");
    let deployment = Deployment::parse("deployment.yaml", "rti: { platform: qemu_cortex_m3, ip: 10.0.0.2 }", &plan);
    let errors = emit(&plan, &settings(&deployment.expect("it is right"))).expect_err("it has a text");
    let errors: Vec<_> = errors.iter().map(ToString::to_string).collect();
    let expected = "P.lf:2:50: error: `String` needs a heap, which `rti`, a board's image that forwards it, does not \
                    have: write `heapless::String<9>`";
    assert_eq!(errors, [expected]);
}

#[test]
fn host_crates() {
    insta::assert_snapshot!("host_crates", listing(&emit_on(&fixture::plan(), &Deployment::default())));
}

#[test]
fn a_board_and_a_host_federate() {
    let plan = fixture::plan();
    let emitted = emit_on(&plan, &mixed(&plan));
    let config: Vec<_> = emitted.files.iter().filter(|file| !file.path.contains("/src/f")).cloned().collect();
    insta::assert_snapshot!("board", listing(&Emitted { files: config, ..emitted.clone() }));
    insta::assert_debug_snapshot!("board_participants", emitted.participants);
}

/// IPv6 costs flash and memory, so an image has it only if it has an address of IPv6.
#[test]
fn images_have_ipv6_only_where_an_address_is() {
    let plan = fixture::plan();
    let mut text = String::new();
    for (deployment, has_ipv6) in [
        ("rti: { ip: 10.0.0.1 }\nfederates: { unit: { platform: native_sim/native/64 } }", false),
        ("rti: { ip: 10.0.0.1 }\nfederates: { unit: { platform: qemu_cortex_m3, ip: 10.0.0.2 } }", false),
        ("rti: { ip: \"::1\" }\nfederates: { unit: { platform: native_sim/native/64 } }", true),
        ("rti: { ip: fd00::1 }\nfederates: { unit: { platform: qemu_cortex_m3, ip: fd00::2 } }", true),
        (
            "rti: { platform: mps2/an385, ip: fd00::1, prefix: 48 }\n\
             federates: { unit: { platform: native_sim/native/64, ip: fd00:0:0:1::2, prefix: 48, gateway: fd00::9 } }",
            true,
        ),
    ] {
        let emitted = emit_on(&plan, &Deployment::parse("deployment.yaml", deployment, &plan).expect("it is right"));
        for file in
            emitted.files.iter().filter(|file| Path::new(&file.path).extension().is_some_and(|end| end == "conf"))
        {
            assert_eq!(file.text.contains("NET_IPV6=y"), has_ipv6, "{deployment}");
            let is_of_addresses = |line: &&str| line.contains("IPV") || line.contains("NEIGHBORS");
            let lines: Vec<_> = file.text.lines().filter(is_of_addresses).collect();
            text = text + deployment + "\n-- " + &file.path + "\n" + &lines.join("\n") + "\n\n";
        }
    }
    insta::assert_snapshot!("ipv6", text);
}

/// The RTI shares an image with a federate, or has its own: its requirements, and the types that it forwards.
#[test]
fn an_rti_in_an_image() {
    let plan = fixture::plan();
    let joint = "federates:\n  unit: { platform: qemu_cortex_m3, ip: 10.0.0.2, joint-rti: true }\n";
    let alone = "rti: { platform: qemu_cortex_m3, ip: 10.0.0.9 }\n";
    let mut text = String::new();
    for (folder, deployment) in [("unit", joint), ("rti", alone)] {
        let deployment = Deployment::parse("deployment.yaml", deployment, &plan).expect("it is right");
        let emitted = emit_on(&plan, &deployment);
        let is_shown = |file: &&File| {
            let path = Path::new(&file.path);
            path.starts_with(folder)
                && (["rti.rs", "lib.rs"].iter().any(|name| path.ends_with(name))
                    || path.extension().is_some_and(|extension| extension == "conf")
                    || folder == "rti" && path.extension().is_some_and(|extension| extension == "rs"))
        };
        let files = emitted.files.iter().filter(is_shown).cloned().collect();
        text += &listing(&Emitted { files, ..emitted.clone() });
        for file in rust_files(&emitted) {
            assert!(syn::parse_file(&file.text).is_ok(), "{}", file.text);
        }
        // Programs of this computer have another clock than an image, even beside it.
        let federate = emitted.files.iter().find(|file| file.path == "other/src/federate.rs").expect("it is emitted");
        assert!(federate.text.contains("local_clock_sync: true"), "{}", federate.text);
    }
    insta::assert_snapshot!("rti", text);
}

#[test]
fn all_federates_look_for_the_rti_where_it_is_deployed() {
    let plan = fixture::plan();
    let emitted = emit_on(&plan, &mixed(&plan));
    let text = |path: &str| &emitted.files.iter().find(|file| file.path == path).expect("it is emitted").text;
    assert!(text("unit/unit.conf").contains("CONFIG_LF_RTI_PORT=15099"));
    for federate in ["unit/src/federate.rs", "other/src/federate.rs"] {
        assert!(text(federate).contains("rti_port: 15099"), "{federate}");
    }
}

#[test]
fn emitted_code_is_rust() {
    let plan = fixture::plan();
    for deployment in [Deployment::default(), all_on(&plan, "some_board")] {
        for file in rust_files(&emit_on(&plan, &deployment)) {
            if let Err(error) = syn::parse_file(&file.text) {
                panic!("{}: {error}\n{}", file.path, file.text);
            }
        }
    }
}

/// Every character of every body, preamble and value has its place in the program.
#[test]
fn verbatim_pieces_map_to_the_same_characters() {
    let lines: Vec<Vec<char>> = fixture::TEXT.lines().map(|line| line.chars().collect()).collect();
    let emitted = emit_on(&fixture::plan(), &Deployment::default());
    let mut mapped = 0;
    for file in rust_files(&emitted) {
        for (line, text) in file.text.lines().enumerate() {
            for (column, character) in text.chars().enumerate() {
                if !emitted.source_map.is_verbatim(&file.path, line + 1, column + 1) {
                    continue;
                }
                let place = emitted.source_map.to_lf(&file.path, line + 1, column + 1);
                let (path, lf_line, lf_column) = place.expect("what is verbatim has a place");
                assert_eq!(path, fixture::PATH);
                // The position behind the last character belongs to the piece, for errors about missing code there.
                let Some(original) = lines[lf_line - 1].get(lf_column - 1) else { continue };
                let next = text.chars().nth(column.wrapping_sub(1));
                assert!(
                    *original == character || next == lines[lf_line - 1].get(lf_column.wrapping_sub(2)).copied(),
                    "{}:{}:{} is {character:?}, but {lf_line}:{lf_column} is {original:?}",
                    file.path,
                    line + 1,
                    column + 1
                );
                mapped += usize::from(*original == character);
            }
        }
    }
    assert!(mapped > 800, "only {mapped} characters were mapped");
}

#[test]
fn errors_in_bodies_and_in_scaffolding_are_found_in_the_program() {
    let emitted = emit_on(&fixture::plan(), &Deployment::default());
    let find = |path: &str, needle: &str| {
        let file = emitted.files.iter().find(|file| file.path == path).expect("it is emitted");
        let (line, text) = file.text.lines().enumerate().find(|(_, text)| text.contains(needle)).expect("it is there");
        let column = text[..text.find(needle).unwrap_or(0)].chars().count() + 1;
        emitted.source_map.to_lf(path, line + 1, column)
    };
    let unit = "unit/src/everything/unit.rs";
    let (line, column) = fixture::place_of("let wrong");
    assert_eq!(find(unit, "let wrong"), Some((fixture::PATH, line, column)));
    let (line, column) = fixture::place_of("limit / HALF");
    assert_eq!(find(unit, "limit / HALF"), Some((fixture::PATH, line, column)));
    // A field's type is that of the declaration.
    let (line, _) = fixture::place_of("state wait");
    assert_eq!(find(unit, "wait: ::core").map(|(_, line, _)| line), Some(line));
    // The rest has no origin in the program.
    assert_eq!(find(unit, "use super"), None);
    assert_eq!(emitted.source_map.to_lf("unit/src/nothing.rs", 1, 1), None);
}

/// A crate that another tool compiles has its own part of the map beside it.
#[test]
fn the_map_of_one_crate_survives_json() {
    let map = emit_on(&fixture::plan(), &Deployment::default()).source_map;
    let json = serde_json::to_string(&map.in_folder("unit")).expect("it is plain data");
    let unit: super::SourceMap = serde_json::from_str(&json).expect("it is plain data");
    let path = "src/everything/unit.rs";
    let places: Vec<_> = (1..200).filter_map(|line| Some((line, unit.to_lf(path, line, 9)?))).collect();
    assert!(places.iter().any(|(line, _)| unit.is_verbatim(path, *line, 9)));
    for (line, place) in places {
        assert_eq!(map.to_lf(&format!("unit/{path}"), line, 9), Some(place));
    }
    assert_eq!(map.in_folder("uni"), map.in_folder("nothing"));
}

#[test]
fn code_that_would_swallow_what_follows_is_refused_at_its_place() {
    for wrong in ["if true {", "}", "\"", "/* "] {
        let mut plan = fixture::plan();
        class(&mut plan, "Unit").reactions[2].body.text = wrong.to_owned();
        let errors = refused(&plan);
        let (line, column) = fixture::place_of(" self.seen +=");
        assert_eq!((errors.len(), errors[0].line, errors[0].column), (1, line, column), "{}", errors[0]);
    }
}

#[test]
fn types_and_missing_values_are_refused_at_their_place() {
    let mut plan = fixture::plan();
    class(&mut plan, "Unit").state[0].ty.text = "Vec<".to_owned();
    let mut errors = refused(&plan);
    let mut plan = fixture::plan();
    class(&mut plan, "Unit").parameters[0].default = None;
    class(&mut plan, "Everything").children[0].arguments[0] = None;
    errors.extend(refused(&plan));
    let mut plan = fixture::plan();
    class(&mut plan, "Everything").parameters[0].default = None;
    errors.extend(refused(&plan));
    let text: Vec<String> = errors.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!("emit_errors", text.join("\n"));
}

#[test]
fn names_that_clash_are_told_apart() {
    let mut plan = fixture::plan();
    plan.files[0].path = "federate.lf".to_owned();
    class(&mut plan, "Unit").children[0].name = "type".to_owned();
    plan.federates[0].instances[1].path = "unit.type".to_owned();
    let raw = plan.federates[0].ports.iter_mut().find(|port| port.path == "unit.first.raw");
    raw.expect("the fixture has it").path = "unit.type".to_owned();
    let filter = class(&mut plan, "Filter");
    filter.name = "unit".to_owned();
    filter.parameters[0].name = "r#type".to_owned();
    filter.state[0].init = Some(Value::Time { ns: 1_500 });
    let emitted = emit_on(&plan, &Deployment::default());
    let paths: Vec<&str> = emitted.files.iter().map(|file| file.path.as_str()).collect();
    assert!(paths.contains(&"unit/src/federate_2/unit.rs") && paths.contains(&"unit/src/federate_2/unit_2.rs"));
    let federate = emitted.files.iter().find(|file| file.path == "unit/src/federate.rs").expect("it is emitted");
    for expected in ["let unit_type = unit.new_type();", "unit_type_2: Port::new"] {
        assert!(federate.text.contains(expected), "{}", federate.text);
    }
    for file in rust_files(&emitted) {
        assert!(syn::parse_file(&file.text).is_ok(), "{}", file.text);
    }
}

/// Unused code would cause warnings in code that the user has not written.
#[test]
fn an_instance_without_reactions_gets_no_variable() {
    let text = "target Rust\nreactor Silent {\n}\nreactor Around {\n  silent = new Silent()\n}\n\
                federated reactor {\n  around = new Around()\n}\n";
    let sources = std::collections::BTreeMap::from([("Quiet.lf".to_owned(), text.to_owned())]);
    let plan = crate::compile("Quiet.lf", &sources).plan.expect("the program is right");
    let emitted = emit_on(&plan, &Deployment::default());
    let federate = emitted.files.iter().find(|file| file.path == "around/src/federate.rs").expect("it is emitted");
    let locals: Vec<&str> =
        federate.text.lines().map(str::trim).filter(|line| line.starts_with("let ") && line.contains('(')).collect();
    assert_eq!(
        locals,
        ["let main = quiet::Quiet::new();", "let around = main.new_around();", "let _ = around.new_silent();"]
    );
}

/// A board has random numbers only if its configuration demands them.
#[test]
fn authentication_asks_zephyr_for_random_numbers() {
    for (properties, expected) in [("", false), (" { auth: true }", true)] {
        let text = format!(
            "target Rust{properties}\nreactor Silent {{\n}}\n\
                            federated reactor {{\n  silent = new Silent()\n}}\n"
        );
        let sources = std::collections::BTreeMap::from([("Quiet.lf".to_owned(), text)]);
        let plan = crate::compile("Quiet.lf", &sources).plan.expect("the program is right");
        let deployment = all_on(&plan, "some_board");
        let emitted = emit_on(&plan, &deployment);
        let fragment =
            emitted.files.iter().find(|file| file.text.contains("CONFIG_LF_SOCKETS")).expect("it is emitted");
        for symbol in ["LF_AUTHENTICATION", "ENTROPY_GENERATOR"] {
            assert_eq!(fragment.text.contains(&format!("CONFIG_{symbol}=y")), expected, "{}", fragment.text);
        }
    }
}
