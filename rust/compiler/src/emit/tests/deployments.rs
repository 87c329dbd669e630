// SPDX-License-Identifier: Apache-2.0
//! Deployment files: what is read from them, and what is refused with its place.

use super::fixture;
use crate::emit::deployment::{Deployment, Mac, Platform};

fn parse(text: &str) -> Result<Deployment, Vec<crate::FileError>> {
    Deployment::parse("deployment.yaml", text, &fixture::plan())
}

#[test]
fn everything_that_can_be_said() {
    let text = "
rti: { platform: host, ip: 10.0.0.1, port: 15045 }
federates:
  unit:
    platform: mimxrt1170_evk@B/mimxrt1176/cm7
    ip: 10.0.0.2
    netmask: 255.255.0.0
    gateway: 10.0.1.1
    mac: 02:00:00:00:00:02
    ethernet: enet1g_mac
    runner: pyocd
    probe: 0240000034544e45
  other: { platform: native_sim/native/64 }
";
    insta::assert_debug_snapshot!("deployment", parse(text).expect("it is right"));
}

#[test]
fn nothing_said_means_this_computer() {
    for text in ["", "# only a comment\n", "federates: {}\n"] {
        let deployment = parse(text).expect("it is right");
        assert_eq!(deployment, Deployment::default(), "{text:?}");
        assert_eq!(deployment.place("unit").platform, Platform::Host);
    }
}

#[test]
fn native_sim_is_recognised_with_and_without_qualifiers() {
    let board = |name: &str| Platform::Zephyr(name.to_owned());
    assert!(board("native_sim").is_native_sim() && board("native_sim/native/64").is_native_sim());
    assert!(!board("native_sim_of_my_own").is_native_sim() && !Platform::Host.is_native_sim());
    assert_eq!(Mac([2, 0, 0, 0xab, 0, 1]).to_string(), "02:00:00:ab:00:01");
}

/// Each wrong file with all that is said about it.
#[test]
fn wrong_files() {
    const BOARD: &str = "platform: qemu_cortex_m3, ip: 10.0.0.2";
    let rti = "rti: { ip: 10.0.0.1 }\n";
    let files = [
        ("no YAML", "federates: [".to_owned()),
        ("an unknown key at the top", "federate: {}\n".to_owned()),
        ("an unknown key of a federate", "federates:\n  unit: { platform: host, prob: x }\n".to_owned()),
        ("an unknown key of the RTI", "rti: { adress: 1 }\n".to_owned()),
        ("a value of the wrong kind", "rti: { port: many }\n".to_owned()),
        ("a port out of range", "rti: { port: 70000 }\n".to_owned()),
        ("port 0", "rti: { port: 0 }\n".to_owned()),
        ("no platform", "federates:\n  unit: { ip: 10.0.0.2 }\n".to_owned()),
        ("the same federate twice", "federates:\n  unit: { platform: host }\n  unit: { platform: host }\n".to_owned()),
        ("an unknown federate", "federates:\n  unti: { platform: host }\n".to_owned()),
        ("joint-rti", "joint-rti: true\n".to_owned()),
        ("an RTI on a board", "rti: { platform: qemu_cortex_m3 }\n".to_owned()),
        ("no name of a platform", "federates:\n  unit: { platform: \"my board\" }\n".to_owned()),
        ("a board without an address", format!("{rti}federates:\n  unit: {{ platform: qemu_cortex_m3 }}\n")),
        (
            "addresses, MAC addresses and probes that occur twice",
            format!(
                "{rti}federates:\n  unit: {{ {BOARD}, mac: 02:00:00:00:00:02, probe: a }}\n  \
                 other: {{ {BOARD}, mac: 02-00-00-00-00-02, probe: a }}\n"
            ),
        ),
        ("the RTI's address on a board", format!("rti: {{ ip: 10.0.0.2 }}\nfederates:\n  unit: {{ {BOARD} }}\n")),
        (
            "addresses that are none",
            format!(
                "rti: {{ ip: localhost }}\nfederates:\n  unit: {{ platform: qemu_cortex_m3, ip: 10.0.0.256 }}\n  \
                 other: {{ {BOARD}, mac: 02:00:00:00:00 }}\n"
            ),
        ),
        (
            "addresses of more than one",
            "rti: { ip: 0.0.0.0 }\nfederates:\n  \
             unit: { platform: mps2/an385, ip: 224.0.0.1, mac: 01:00:00:00:00:01 }\n"
                .to_owned(),
        ),
        (
            "a network that does not fit",
            format!("{rti}federates:\n  unit: {{ {BOARD}, netmask: 255.0.255.0, gateway: 10.9.0.1 }}\n"),
        ),
        ("an RTI that boards cannot reach", format!("rti: {{ ip: 127.0.0.1 }}\nfederates:\n  unit: {{ {BOARD} }}\n")),
        ("an RTI in another network", format!("rti: {{ ip: 10.9.9.9 }}\nfederates:\n  unit: {{ {BOARD} }}\n")),
        ("an RTI that boards do not know", format!("federates:\n  unit: {{ {BOARD} }}\n")),
        (
            "keys of boards for programs of this computer",
            "federates:\n  unit: { platform: host, ip: 10.0.0.2 }\n  \
             other: { platform: native_sim/native/64, mac: 02:00:00:00:00:02, probe: a }\n"
                .to_owned(),
        ),
        (
            "a MAC address without a known place",
            format!("{rti}federates:\n  unit: {{ platform: my_board, ip: 10.0.0.2, mac: 02:00:00:00:00:02 }}\n"),
        ),
        ("no devicetree label", format!("{rti}federates:\n  unit: {{ {BOARD}, ethernet: \"&eth\" }}\n")),
    ];
    let mut text = String::new();
    for (what, file) in files {
        let errors = parse(&file).expect_err(what);
        text = text + "==== " + what + "\n" + &file + "----\n";
        for error in errors {
            text = text + &error.to_string() + "\n";
        }
    }
    insta::assert_snapshot!("wrong_deployments", text);
}
