// SPDX-License-Identifier: Apache-2.0
//! The program prints lines of JSON, which `scripts/lf_evaluate` reads.

use std::process::Command;

use serde_json::Value;

fn lines(arguments: &[&str]) -> Vec<Value> {
    let output = Command::new(env!("CARGO_BIN_EXE_lf-bench")).args(arguments).output().expect("it was built");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("it is text");
    text.lines().map(|line| serde_json::from_str(line).expect("each line is JSON")).collect()
}

#[test]
fn each_line_is_a_value_with_its_part_row_owner_and_unit() {
    let lines = lines(&["clock", "--rounds", "1"]);
    for line in &lines {
        assert!(["row", "who", "unit"].iter().all(|key| line[key].is_string()) && line["part"] == "clock", "{line}");
        assert!(line["value"].is_f64(), "{line}");
    }
    let looks: Vec<_> = lines.iter().filter_map(|line| line["samples"].as_array()).map(Vec::len).collect();
    assert_eq!(looks, [60, 60], "a look at the clocks in each second, once and while the program runs");
}

#[test]
fn an_rti_that_cannot_be_started_is_an_error_in_its_row() {
    let lines = lines(&["large", "--federates", "2", "--lfz", "/dev/null/lfz"]);
    let [line] = &lines[..] else { panic!("there is one run: {lines:?}") };
    assert!(line["error"].as_str().is_some_and(|error| error.contains("lfz rti cannot be started")), "{line}");
    assert!(line.get("value").is_none(), "{line}");
}
