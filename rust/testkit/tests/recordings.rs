// SPDX-License-Identifier: Apache-2.0
//! All recordings of the repository load, and the loader rejects files that violate the format, with a reason.

use lf_testkit::golden::{Coordination, Fill, RelativeTag, Step, load, load_all, parse};

#[test]
fn every_recording_loads_and_no_step_is_lost() {
    let recordings = load_all().unwrap();
    assert_eq!(recordings.len(), 96);
    assert_eq!(recordings.iter().filter(|recording| recording.rti().is_some()).count(), 83);
    assert_eq!(recordings.iter().filter(|recording| recording.federate().is_some()).count(), 13);
    assert_eq!(recordings.iter().filter(|recording| recording.quirk.is_some()).count(), 24);
    let (mut sent, mut received, mut others) = (0, 0, 0);
    for step in recordings.iter().flat_map(|recording| &recording.steps) {
        match step {
            Step::Send(_) | Step::UdpSend(_) => sent += 1,
            Step::Recv(_) | Step::UdpRecv { .. } => received += 1,
            _ => others += 1,
        }
    }
    assert_eq!((sent, received, others), (2748 + 17, 1848 + 16, 275 + 3 + 256 + 249 + 6 + 102 + 7 + 1));
}

#[test]
fn the_setup_of_both_roles_is_typed() {
    let rti = load("32-start-time-multiple").unwrap();
    assert_eq!(rti.rti().unwrap().options, ["-m", "7", "s", "-c", "off"]);
    let federate = load("52b-decentralized-sink").unwrap();
    assert_eq!(federate.federate().unwrap().coordination, Coordination::Decentralized);
    assert_eq!(federate.federate().unwrap().exit_code, Some(0));
    let tagged = federate.steps.iter().filter_map(|step| match step {
        Step::Send(frame) => frame.tag.map(|tag| (tag, frame.fill.clone())),
        _ => None,
    });
    let first = RelativeTag { time_ns: 0, microstep: 0 };
    assert_eq!(tagged.take(1).collect::<Vec<_>>(), [(first, Some(Fill::TagTime))]);
}

#[test]
fn a_missing_recording_is_named() {
    assert!(load("99-nothing").unwrap_err().to_string().contains("99-nothing.json"));
}

/// Returns a recording with this one step.
fn with_step(step: &str) -> String {
    format!(
        r#"{{"name": "n", "description": "d", "source": "s", "role": "rti", "rti_exit_code": null, "steps": [{step}],
            "rti": {{"federates": 1, "federation_id": "f", "options": [], "auth": false}}}}"#
    )
}

#[test]
fn steps_that_do_not_follow_the_format_are_refused_with_a_reason() {
    assert!(parse(&with_step(r#"{"connect": 0, "note": "n"}"#)).is_ok());
    let refused = [
        (r#"{"conect": 0}"#, "unknown field `conect`"),
        (r#"{"note": "n"}"#, "step 0: has 0 actions"),
        (r#"{"connect": 0, "close": 0}"#, "step 0: has 2 actions"),
        (r#"{"connect": 0, "hex": "00"}"#, "`hex` does not belong here"),
        (r#"{"send": 0, "msg": "m"}"#, "`hex` is missing"),
        (r#"{"send": 0, "hex": "04"}"#, "`msg` is missing"),
        (r#"{"send": 0, "hex": "0g", "msg": "m"}"#, "byte 0 is neither"),
        (r#"{"send": 0, "hex": "04", "msg": "m", "from_port": 1}"#, "`from_port` does not belong here"),
        (r#"{"send": 0, "hex": "fe....", "msg": "m"}"#, "2 bytes are masked, but it is said how to fill 0"),
        (r#"{"send": 0, "hex": "fe....", "msg": "m", "fill": "start"}"#, "2 bytes are masked"),
        (r#"{"send": 0, "hex": "fe....", "msg": "m", "fill": "other"}"#, "did not match any variant"),
        (r#"{"recv": 0, "hex": "fe....", "msg": "m", "fill": "udp_port"}"#, "does not belong to what is received"),
        (r#"{"recv": 0, "hex": "06", "msg": "m", "tag": [0, 0]}"#, "another number of bytes is masked"),
        (r#"{"connect": 65536}"#, "65536"),
    ];
    for (step, reason) in refused {
        let error = parse(&with_step(step)).unwrap_err();
        assert!(error.contains(reason), "{step}: {error}");
    }
}

#[test]
fn a_recording_without_the_setup_of_its_role_is_refused() {
    let good = with_step("");
    assert_eq!(parse(&good).unwrap().rti().unwrap().exit_code, None);
    for (from, to) in [
        (r#""role": "rti""#, r#""role": "federate""#),
        (r#""rti_exit_code": null, "#, ""),
        (r#""rti_exit_code": null"#, r#""rti_exit_code": null, "federate_exit_code": 0"#),
    ] {
        assert!(parse(&good.replace(from, to)).unwrap_err().contains("needs"), "{from}");
    }
    let unknown = good.replace(r#""name""#, r#""extra": 1, "name""#);
    assert!(parse(&unknown).unwrap_err().contains("unknown field `extra`"));
}
