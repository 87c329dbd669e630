// SPDX-License-Identifier: Apache-2.0
//! Physical connections between real processes.

use lf_federations::{Lfz, programs};

#[test]
fn values_go_from_federate_to_federate_in_order() {
    let finished = Lfz::run("direct", &programs().join("Direct.lf"), &[]).succeed();
    let result = finished.of("sink").find(|line| line.starts_with("more than"));
    assert_eq!(result, Some("more than 40 of each: true"), "{finished}");
}
