// SPDX-License-Identifier: Apache-2.0
//! Edges of pins of two federates on Linux: recorded on one clock, and compared by `lfz scope`.

use std::path::Path;

use lf_federations::Lfz;

const PROGRAM: &str = "applications/clock_sync/src/ClockSyncPins.lf";

#[test]
fn every_edge_of_one_federate_has_its_partner_at_the_other() {
    let folder = tempfile::tempdir().expect("there is room");
    let [vcd, svg] = ["pins.vcd", "edges.svg"].map(|name| folder.path().join(name));
    let text = |path: &Path| path.to_str().expect("the folder's name is text").to_owned();
    let run = Lfz::run("pins", Path::new(PROGRAM), &["--vcd", &text(&vcd), "--timeout", "4 s"]).finish();
    assert!(run.lines.iter().any(|line| line.contains("2 pins recorded: ")), "{run}");

    let scope = |words: &[&str]| {
        let output = Lfz::command(["scope"]).arg(&vcd).args(words).output().expect("it can be run");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("it is text")
    };
    assert_eq!(scope(&[]).lines().count(), 2);
    let told = scope(&["--reference", "a.led0", "--compare", "b.led0", "--json", "--svg", &text(&svg)]);
    let told: serde_json::Value = serde_json::from_str(&told).expect("it is JSON");
    let compared = &told["compared"][0];
    assert!(told["edges"].as_u64() >= Some(4), "{told}");
    // The end of the run may cut off the last edge of one.
    assert!(compared["missing"].as_u64() <= Some(1) && compared["extra"].as_u64() <= Some(1), "{told}");
    assert!(compared["drift"]["slope_us_per_s"].is_f64(), "{told}");
    let drawn = std::fs::read_to_string(&svg).expect("it was drawn");
    assert!(drawn.starts_with("<svg") && drawn.trim_end().ends_with("</svg>"), "{drawn}");
}
