// SPDX-License-Identifier: Apache-2.0
//! The plan and all emitted files of the programs in `applications/`.

use std::path::Path;

use super::{all_on, emit_on, listing, rust_files};
use crate::deployment::{Deployment, Platform};
use crate::plan::Plan;
use crate::{SourceProvider, Style, compile};

/// The files of the repository.
struct Repository;

impl SourceProvider for Repository {
    fn read(&self, path: &str) -> Result<String, String> {
        std::fs::read_to_string(root().join(path)).map_err(|error| error.to_string())
    }
}

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn plan(path: &str) -> Plan {
    let compilation = compile(path, &Repository);
    let said = compilation.diagnostics.render(Style::Plain);
    assert_eq!(said, "", "{path} is right");
    compilation.plan.expect("there is no error")
}

fn check(name: &str, path: &str) {
    let plan = plan(path);
    insta::assert_snapshot!(format!("{name}_plan"), plan);
    let emitted = emit_on(&plan, &Deployment::default());
    insta::assert_snapshot!(format!("{name}_host"), listing(&emitted));
    // The reactors are the same for an image; the listing shows the differences.
    let mut image = emit_on(&plan, &all_on(&plan, "native_sim/native/64"));
    let host = emitted.files;
    image.files.retain(|file| !host.contains(file));
    for file in rust_files(&image) {
        assert!(syn::parse_file(&file.text).is_ok(), "{}", file.path);
    }
    insta::assert_snapshot!(format!("{name}_native_sim"), listing(&image));
}

#[test]
fn hello_world() {
    check("hello_world", "applications/hello_world/src/HelloWorld.lf");
}

#[test]
fn message_test() {
    check("message_test", "applications/message_test/src/MessageTest.lf");
}

#[test]
fn message_test_slow_uses_the_same_reactors() {
    let (fast, slow) = (
        plan("applications/message_test/src/MessageTest.lf"),
        plan("applications/message_test/src/MessageTestSlow.lf"),
    );
    let sender = |plan: &Plan| {
        let file = |emitted: crate::emit::Emitted| {
            emitted.files.into_iter().find(|file| file.path == "sender/src/message_test/sender.rs")
        };
        file(emit_on(plan, &Deployment::default())).expect("it is emitted").text
    };
    let without_header = |text: String| text.split_once('\n').expect("it has lines").1.to_owned();
    assert_eq!(without_header(sender(&fast)), without_header(sender(&slow)));
    let period = |plan: &Plan| plan.to_string().contains("sender.t: timer at 1 s, every 100 ms");
    assert!(period(&slow) && !period(&fast));
}

#[test]
fn smart_grid() {
    check("smart_grid", "applications/smart_grid/src/SmartGrid.lf");
}

/// Inputs whose messages can be tardy have other queues, and reactions that handle them another method.
#[test]
fn a_decentralized_federate() {
    let plan = plan("rust/compiler/tests/plans/decentralized.lf");
    let mut emitted = emit_on(&plan, &Deployment::default());
    emitted.files.retain(|file| file.path.starts_with("c/src/"));
    insta::assert_snapshot!("decentralized_federate", listing(&emitted));
}

#[test]
fn the_deployments_beside_the_programs_are_right() {
    let programs = [
        ("applications/smart_grid/src/SmartGrid.lf", "applications/smart_grid/deployment/topology2.yaml", 2),
        ("applications/smart_grid/src/SmartGrid.lf", "applications/smart_grid/deployment/native_sim.yaml", 4),
        ("applications/message_test/src/MessageTest.lf", "applications/message_test/deployment/native_sim.yaml", 2),
        ("applications/message_test/src/MessageTestSlow.lf", "applications/message_test/deployment/native_sim.yaml", 2),
        ("applications/smart_grid/src/SmartGrid.lf", "applications/smart_grid/deployment/boards.yaml", 4),
        ("applications/message_test/src/MessageTest.lf", "applications/message_test/deployment/topology1.yaml", 1),
        ("applications/message_test/src/MessageTest.lf", "applications/message_test/deployment/topology2.yaml", 2),
        ("applications/message_test/src/MessageTest.lf", "applications/message_test/deployment/topology4.yaml", 2),
        ("applications/smart_grid/src/SmartGrid.lf", "applications/smart_grid/deployment/topology3.yaml", 4),
        ("applications/smart_grid/src/SmartGrid.lf", "applications/smart_grid/deployment/topology4.yaml", 4),
        (
            "applications/message_test/src/MessageTestDecentralized.lf",
            "applications/message_test/deployment/mps2.yaml",
            2,
        ),
    ];
    for (program, path, images) in programs {
        let text = std::fs::read_to_string(root().join(path)).expect("it is there");
        let deployment = Deployment::parse(path, &text, &plan(program)).expect("it is right");
        let on_zephyr = deployment.federates.values().filter(|place| place.platform != Platform::Host);
        assert_eq!(on_zephyr.count(), images, "{path}");
    }
}
