// SPDX-License-Identifier: Apache-2.0
//! Warnings about programs that are encrypted only in part.

use std::collections::BTreeMap;

use lf_compiler::{Code, compile};

/// Returns the warnings about a federation with these target properties.
fn warnings(properties: &str) -> Vec<Code> {
    let text = format!("target Rust {{ {properties} }} reactor A {{ }} federated reactor {{ a = new A() }}");
    let compilation = compile("Main.lf", &BTreeMap::from([("Main.lf".to_owned(), text)]));
    assert!(compilation.plan.is_some());
    compilation.diagnostics.iter().map(|entry| entry.code).collect()
}

/// TLS is for connections, and clocks are compared by datagrams while a program runs; before the start they are not.
#[test]
fn clocks_that_tls_leaves_open_are_a_warning() {
    for tls in ["comm-type: TLS", "comm-type: TLS, security: unverified"] {
        assert_eq!(warnings(&format!("{tls}, clock-sync: on")), [Code::OpenClocks]);
        assert_eq!(warnings(&format!("clock-sync: on, {tls}")), [Code::OpenClocks]);
        assert_eq!(warnings(&format!("{tls}, clock-sync: init")), []);
        assert_eq!(warnings(tls), []);
    }
    assert_eq!(warnings("security: noise, clock-sync: on"), []);
    assert_eq!(warnings("clock-sync: on"), []);
}
