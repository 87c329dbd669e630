// SPDX-License-Identifier: Apache-2.0
//! The meaning of modes. The scenarios in `programs/modes` are those of LF's own tests and some more; `README.md` says
//! which of LF's own each covers.
//!
//! `cargo xtask bless -p lf-federations modes::` rewrites the traces.

use lf_federations::{Lfz, is_of_build, programs};

#[test]
fn time_state_and_structure_of_modes() {
    let finished = Lfz::run("modes", &programs().join("modes/Modes.lf"), &[]).succeed();
    // The lines are sorted by scenario, because those of one tag do not depend on each other.
    let mut lines: Vec<&str> = finished.lines.iter().map(String::as_str).filter(|line| !is_of_build(line)).collect();
    lines.sort_by_key(|line| line.split(' ').next());
    insta::with_settings!({
        snapshot_path => "../programs/modes",
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!("Modes", lines.join("\n"));
    });
}
