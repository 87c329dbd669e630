// SPDX-License-Identifier: Apache-2.0
//! Deployment files: their contents, and errors with their places.

use super::fixture;
use crate::deployment::{Deployment, Mac, Platform, RtiHome, RtiPlace};
use crate::plan::Plan;

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

/// A federate that fails takes the federation with it, unless it is transient.
#[test]
fn only_transient_federates_start_again() {
    let text = |restart: &str| format!("federates:\n  unit: {{ platform: host, restart: {restart} }}\n");
    let mut plan = fixture::plan();
    let mut parse = |restart: &str, is_transient: bool| {
        plan.federates.iter_mut().for_each(|federate| federate.transient = is_transient);
        let parsed = Deployment::parse("deployment.yaml", &text(restart), &plan);
        parsed.map(|deployment| deployment.place("unit").restarts).map_err(|errors| errors[0].message.clone())
    };
    assert_eq!(
        [parse("on-failure", true), parse("never", true), parse("never", false)],
        [Ok(true), Ok(false), Ok(false)]
    );
    let refused = parse("on-failure", false).expect_err("it is persistent");
    assert!(refused.contains("unit is not transient"), "{refused}");
    assert!(parse("always", true).expect_err("there is no such word").contains("\"always\" is not known"));
}

/// A spare board is where the first one is, apart from its addresses, and only what is swapped has one.
#[test]
fn a_transient_federate_can_have_a_spare_board() {
    let mut plan = fixture::plan();
    let parse = |plan: &Plan, unit: &str, other: &str| {
        let text = format!("rti: {{ ip: 10.0.0.1 }}\nfederates:\n  unit: {unit}\n  other: {other}\n");
        Deployment::parse("deployment.yaml", &text, plan).map_err(|errors| {
            let lines = errors.iter().map(|error| error.message.clone() + "; " + error.hint.as_deref().unwrap_or("-"));
            lines.collect::<Vec<_>>().join("\n")
        })
    };
    let unit = "{ platform: qemu_cortex_m3, ip: 10.0.0.2, runner: qemu, spare: { ip: 10.0.0.12, probe: B2 } }";
    let other = "{ platform: qemu_cortex_m3, ip: 10.0.0.3 }";
    let refused = parse(&plan, unit, other).expect_err("it is persistent");
    assert!(refused.contains("unit is not transient") && refused.contains("write `@transient`"), "{refused}");
    plan.federates.iter_mut().for_each(|federate| federate.transient = true);
    let deployment = parse(&plan, unit, other).expect("it is right");
    assert_eq!((deployment.spares(), deployment.with_spare("other")), (1, None));
    let spare = deployment.with_spare("unit").expect("it has one").place("unit");
    let first = deployment.place("unit");
    assert_eq!(spare.address(), Some("10.0.0.12".parse().expect("an address")));
    assert_eq!((spare.mac, &spare.platform), (Some(Mac([2, 0, 10, 0, 0, 12])), &first.platform));
    assert_eq!((spare.runner.as_deref(), spare.probe.as_deref()), (Some("qemu"), Some("B2")));
    assert_eq!(spare.spare.and_then(|back| back.address()), first.address());
    for (unit, words) in [
        ("{ platform: host, spare: { ip: 10.0.0.12 } }", "`spare` has no meaning for platform host"),
        ("{ platform: native_sim, spare: { ip: 10.0.0.12 } }", "a program of this computer can run twice"),
        ("{ platform: qemu_cortex_m3, ip: 10.0.0.2, spare: { ip: 10.0.0.3 } }", "already that of \"unit\""),
        ("{ platform: qemu_cortex_m3, ip: 10.0.0.2, spare: { ip: 10.0.0.2 } }", "already that of \"unit\""),
        ("{ platform: qemu_cortex_m3, ip: 10.0.0.2, spare: { ip: 10.9.0.2 } }", "10.9.0.2 is not in the network of"),
        ("{ platform: qemu_cortex_m3, ip: 10.0.0.2, spare: { mac: '02:00:00:00:00:02' } }", "missing field `ip`"),
        ("{ platform: b, ip: 10.0.0.2, ethernet: e, mac: '02:00:00:00:00:02', spare: { ip: 10.0.0.9 } }", "one MAC"),
        (
            "{ platform: b, ip: 10.0.0.2, ethernet: e, probe: B2, spare: { ip: 10.0.0.9, probe: B2 } }",
            "already that of",
        ),
        ("{ platform: b, ip: 10.0.0.2, joint-rti: true, spare: { ip: 10.0.0.9 } }", "unit has the RTI in its image"),
    ] {
        let refused = parse(&plan, unit, other).expect_err(unit);
        assert!(refused.contains(words), "{unit}: {refused}");
    }
}

fn home_of(properties: &str, text: &str) -> Result<RtiPlace, Vec<crate::FileError>> {
    let mut plan = fixture::plan();
    plan.target.joint_rti = properties.contains("joint-rti");
    if let (Some(rti), Some((_, at))) = (plan.rti.as_mut(), properties.split_once("at ")) {
        rti.host = at.to_owned();
    }
    Deployment::parse("deployment.yaml", text, &plan).map(|deployment| deployment.rti)
}

const FIRST: &str = "unit: { platform: qemu_cortex_m3, ip: 10.0.0.2";
const SECOND: &str = "other: { platform: qemu_cortex_m3, ip: 10.0.0.3";

/// An image that contains the RTI determines the RTI's address, whether the file or the program demands it.
#[test]
fn the_rti_is_where_its_image_is() {
    let joint = |name: &str| RtiHome::Joint(name.to_owned());
    let both = format!("federates:\n  {FIRST} }}\n  {SECOND} }}\n");
    let chosen = format!("rti: {{ port: 15099 }}\nfederates:\n  {FIRST} }}\n  {SECOND}, joint-rti: true }}\n");
    let only = format!("federates:\n  {FIRST} }}\n  other: {{ platform: host }}\n");
    let simulated = "federates:\n  other: { platform: native_sim/native/64, joint-rti: true }\n";
    let here = "federates:\n  other: { platform: native_sim/native/64 }\n";
    let own = format!("rti: {{ platform: host, ip: 10.0.0.1 }}\n{only}");
    for (properties, text, home, ip) in [
        ("", chosen.as_str(), joint("other"), Some([10, 0, 0, 3])),
        ("joint-rti", &chosen, joint("other"), Some([10, 0, 0, 3])),
        ("joint-rti at 10.0.0.2", &both, joint("unit"), Some([10, 0, 0, 2])),
        ("joint-rti", &only, joint("unit"), Some([10, 0, 0, 2])),
        ("", simulated, joint("other"), Some([127, 0, 0, 1])),
        ("joint-rti", here, RtiHome::Program, None),
        ("joint-rti", &own, RtiHome::Program, Some([10, 0, 0, 1])),
    ] {
        let rti = home_of(properties, text).expect(text);
        assert_eq!((rti.home, rti.ip), (home, ip.map(core::net::IpAddr::from)), "{properties} {text}");
    }
    assert_eq!(home_of("", &chosen).expect("it is right").port, Some(15099));
    let errors = home_of("joint-rti", &both).expect_err("it does not say which");
    assert_eq!(errors.len(), 3, "and no board knows the RTI");
    assert!(errors.iter().any(|error| error.to_string().contains("to one of other, unit")), "{errors:?}");
}

#[test]
fn an_rti_of_its_own_has_the_keys_of_a_federate() {
    let board = "rti: { platform: qemu_cortex_m3, ip: 10.0.0.9, mac: 02:00:00:00:00:09, runner: pyocd, probe: a }";
    let rti = home_of("joint-rti", board).expect("it is right");
    assert_eq!(rti.ip, Some([10, 0, 0, 9].into()));
    let RtiHome::Image(place) = rti.home else { panic!("{rti:?}") };
    assert_eq!((place.runner.as_deref(), place.probe.as_deref()), (Some("pyocd"), Some("a")));
    assert_eq!(place.mac, Some(Mac([2, 0, 0, 0, 0, 9])));
    let here = home_of("", "rti: { platform: native_sim/native/64 }").expect("it is right");
    assert_eq!(here.ip, Some([127, 0, 0, 1].into()));
}

/// With an address, an image for `native_sim` has a network stack of its own.
#[test]
fn a_simulated_board_with_an_address_is_not_offloaded() {
    let text = "rti: { ip: 10.0.0.1 }\nfederates:\n  \
                unit: { platform: native_sim/native/64, ip: 10.0.0.2, mac: 02:00:00:00:00:02 }\n  \
                other: { platform: native_sim/native/64 }\n";
    let deployment = parse(text).expect("it is right");
    assert!(!deployment.place("unit").is_offloaded() && deployment.place("other").is_offloaded());
}

const BOARD: &str = "platform: qemu_cortex_m3, ip: 10.0.0.2";

/// Each wrong file has all its errors reported.
#[test]
fn wrong_files() {
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
        ("joint-rti at the top", "joint-rti: true\n".to_owned()),
        ("an RTI on a board without an address", "rti: { platform: qemu_cortex_m3 }\n".to_owned()),
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
    insta::assert_snapshot!("wrong_deployments", errors_of(&files));
}

/// Wrong addresses of IPv6 are reported.
#[test]
fn wrong_addresses_of_ipv6() {
    let rti = "rti: { ip: 10.0.0.1 }\n";
    let files = [
        (
            "IPv6 addresses that are none",
            "rti: { ip: \"fd00::1::2\" }\nfederates:\n  unit: { platform: qemu_cortex_m3, ip: \"fd00::g\" }\n"
                .to_owned(),
        ),
        (
            "IPv6 addresses that do not fit",
            "rti: { ip: \"fe80::1\" }\nfederates:\n  unit: { platform: qemu_cortex_m3, ip: \"ff02::1\" }\n  \
             other: { platform: qemu_cortex_m3, ip: \"::ffff:10.0.0.3\" }\n"
                .to_owned(),
        ),
        (
            "an IPv6 network that does not fit",
            "rti: { ip: \"fd00::1\" }\nfederates:\n  \
             unit: { platform: qemu_cortex_m3, ip: \"fd00::2\", netmask: 255.255.0.0, prefix: 129 }\n  \
             other: { platform: qemu_cortex_m3, ip: \"fd00:0:0:1::3\", gateway: \"fd00::9\" }\n"
                .to_owned(),
        ),
        ("a prefix of IPv4", format!("{rti}federates:\n  unit: {{ {BOARD}, prefix: 24 }}\n")),
        (
            "an RTI in another IPv6 network",
            "rti: { ip: \"fd00:1::1\" }\nfederates:\n  unit: { platform: qemu_cortex_m3, ip: \"fd00:2::2\" }\n"
                .to_owned(),
        ),
        (
            "an RTI of the other family",
            "rti: { ip: \"fd00::1\" }\nfederates:\n  unit: { platform: qemu_cortex_m3, ip: 10.0.0.2 }\n".to_owned(),
        ),
    ];
    insta::assert_snapshot!("wrong_addresses_of_ipv6", errors_of(&files));
}

/// Wrong places of the RTI are reported.
#[test]
fn wrong_places_of_the_rti() {
    let rti = "rti: { ip: 10.0.0.1 }\n";
    let files = [
        ("a board for an RTI that is none", "rti: { ip: 10.0.0.1, mac: 02:00:00:00:00:02, probe: a }\n".to_owned()),
        (
            "an RTI's image on this computer, which boards do not reach",
            format!("rti: {{ platform: native_sim/native/64 }}\nfederates:\n  unit: {{ {BOARD} }}\n"),
        ),
        (
            "a joint RTI on this computer, which boards do not reach",
            format!(
                "federates:\n  unit: {{ {BOARD} }}\n  other: {{ platform: native_sim/native/64, joint-rti: true }}\n"
            ),
        ),
        (
            "a joint RTI that is somewhere else",
            format!(
                "rti: {{ platform: host, ip: 10.0.0.1 }}\nfederates:\n  unit: {{ {BOARD}, joint-rti: true }}\n  \
                 other: {{ platform: host, joint-rti: true }}\n"
            ),
        ),
        (
            "two joint RTIs with an address of their own",
            format!(
                "{rti}federates:\n  unit: {{ {BOARD}, joint-rti: true }}\n  \
                 other: {{ platform: qemu_cortex_m3, ip: 10.0.0.3, joint-rti: true }}\n"
            ),
        ),
    ];
    insta::assert_snapshot!("wrong_places_of_the_rti", errors_of(&files));
}

fn errors_of(files: &[(&str, String)]) -> String {
    let mut text = String::new();
    for (what, file) in files {
        let errors = parse(file).expect_err(what);
        text = text + "==== " + what + "\n" + file + "----\n";
        for error in errors {
            text = text + &error.to_string() + "\n";
        }
    }
    text
}
