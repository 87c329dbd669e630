// SPDX-License-Identifier: Apache-2.0
//! Where the recorded RTI does something that looks accidental, ours does the better thing. Each test plays the
//! recording with the one expectation changed, and so says what differs and that nothing else does.

use lf_testkit::golden::replay::replay;
use lf_testkit::golden::{Frame, Recording, Step};
use lf_testkit::rti::Recorded;

/// `FED_IDS` of federate 0 of the default federation.
const IDS_0: &str = "01000017556e6964656e7469666965642046656465726174696f6e";

const TAG_FOREVER: &str = "07ffffffffffffff7fffffffff";

fn load(name: &str) -> Recording {
    let recording = lf_testkit::golden::load(name).unwrap_or_else(|error| panic!("{error}"));
    assert!(recording.quirk.is_some(), "{name} is marked as accidental");
    recording
}

fn frame(connection: u16, hex: &str) -> Frame {
    let bytes = hex.parse().expect("it is hexadecimal");
    Frame { connection, bytes, fill: None, tag: None, message: String::new(), note: None }
}

fn play(recording: &Recording) -> Recorded {
    play_in_pieces(recording, usize::MAX)
}

/// Plays a recording in pieces of this many bytes.
fn play_in_pieces(recording: &Recording, piece: usize) -> Recorded {
    let mut rti = Recorded::new(recording.rti().expect("it is the recording of an RTI"), piece);
    if let Err(difference) = replay(recording, &mut rti) {
        panic!("{difference}\n{:#?}", rti.rig.outlet.log_events);
    }
    rti
}

/// Returns the position of a received message of this connection.
fn received(recording: &Recording, connection: u16) -> usize {
    let is_it = |step: &Step| matches!(step, Step::Recv(frame) if frame.connection == connection);
    recording.steps.iter().position(is_it).expect("the recording has such a step")
}

/// 35: the recorded RTI refuses before the peer has said anything, as if its federation were the wrong one.
#[test]
fn a_late_connection_is_told_that_its_id_is_in_use() {
    let mut recording = load("35-late-connection");
    for connection in [100, 101] {
        let at = received(&recording, connection);
        recording.steps[at] = Step::Recv(frame(connection, "0002"));
        recording.steps.insert(at, Step::Send(frame(connection, IDS_0)));
    }
    play(&recording);
}

/// 36: the recorded RTI accepts every prefix of the federation id.
#[test]
fn a_prefix_of_the_federation_id_is_another_federation() {
    let mut recording = load("36-federation-id-prefix");
    let at = received(&recording, 0);
    recording.steps.truncate(at);
    recording.steps.extend([
        Step::Recv(frame(0, "0001")),
        Step::ClosedByPeer(0),
        Step::Close(0),
        Step::Connect(101),
        Step::Send(frame(101, "01010000")),
        Step::Recv(frame(101, "0001")),
        Step::ClosedByPeer(101),
        Step::Close(101),
        Step::Connect(1),
        Step::Send(frame(1, "01010006616263646566")),
        Step::Recv(frame(1, "ff")),
    ]);
    let rti = play(&recording);
    let refused = "a connection was refused that claims to be federate 0 of federation \"abc\": \
                   the federation id does not match (code 1)";
    assert!(rti.rig.outlet.log_events.iter().any(|event| event.starts_with(refused)));
}

/// 39: in the recorded RTI the id stays taken, and the federation can never be complete.
#[test]
fn an_id_is_free_again_after_its_handshake_was_refused() {
    let mut recording = load("39-handshake-order");
    let at = received(&recording, 100);
    recording.steps.truncate(at);
    recording.steps.push(Step::Recv(frame(100, "ff")));
    play(&recording);
}

/// 42: the recorded RTI looks at the federates upstream of a PTAG only when it sends the grant, so that one which
/// cannot follow at once never does, and the cycle waits forever.
#[test]
fn a_ptag_reaches_upstream_federates_as_soon_as_they_can_follow() {
    let mut recording = load("42-ptag-not-repeated");
    let moves_on = |step: &Step| matches!(step, Step::Send(frame) if frame.message == "NET (start+20000000, 0)");
    let at = recording.steps.iter().position(moves_on).expect("0 moves on");
    // PTAG (start+10000000, 0).
    recording.steps.insert(at + 1, Step::Recv(frame(1, "08506897e3b3b6e00d00000000")));
    play(&recording);
}

/// 29: the recorded RTI rejects a wrong key, and then aborts.
#[test]
fn a_wrong_key_is_rejected_and_the_right_one_is_accepted_afterwards() {
    let mut recording = load("29-auth-rejected");
    let accepted = lf_testkit::golden::load("28-auth-accepted").unwrap_or_else(|error| panic!("{error}"));
    let acknowledged = received_again(&accepted, 0);
    recording.steps.extend_from_slice(&accepted.steps[..=acknowledged]);
    let rti = play(&recording);
    let refused = "a connection was refused that claims to be federate 0: the HMAC does not match (code 6)";
    assert_eq!(rti.rig.outlet.log_events[0], refused);
}

/// 29b: the recorded RTI does not answer and ends. Ours says with code 4 that it expects another message, also to a
/// federate whose first message is shorter than the one that is expected, and goes on.
#[test]
fn a_federate_that_does_not_authenticate_is_rejected_and_others_are_accepted_afterwards() {
    let mut recording = load("29b-auth-missing");
    let accepted = lf_testkit::golden::load("28-auth-accepted").unwrap_or_else(|error| panic!("{error}"));
    let closed = Step::ClosedByPeer(100);
    let at = recording.steps.iter().position(|step| *step == closed).expect("the RTI closes the connection");
    recording.steps.insert(at, Step::Recv(frame(100, "0004")));
    recording.steps.extend([
        Step::Connect(101),
        Step::Send(frame(101, "01000000")),
        Step::Recv(frame(101, "0004")),
        Step::ClosedByPeer(101),
    ]);
    recording.steps.extend_from_slice(&accepted.steps[..=received_again(&accepted, 0)]);
    let rti = play(&recording);
    let log_events = &rti.rig.outlet.log_events;
    assert!(log_events[..2].iter().all(|event| event.contains("auth: true")), "{log_events:#?}");
}

/// A transient federate learns at once that it cannot join.
#[test]
fn a_transient_federate_is_refused_and_named() {
    let mut recording = lf_testkit::golden::load("0.13/03-persistent-by-103").unwrap_or_else(|error| panic!("{error}"));
    let ids = "6700001701556e6964656e7469666965642046656465726174696f6e";
    let refused = [
        Step::Connect(100),
        Step::Send(frame(100, ids)),
        Step::Recv(frame(100, "0004")),
        Step::ClosedByPeer(100),
        Step::Close(100),
    ];
    let at = closed(&recording, 0);
    recording.steps.insert(at + 1, Step::Recv(frame(1, TAG_FOREVER)));
    recording.steps.splice(0..0, refused);
    let rti = play(&recording);
    let told = "a connection was refused that claims to be federate 0: the message was not expected (code 4); it is a \
                transient federate";
    assert!(rti.rig.outlet.log_events[0].starts_with(told), "{:#?}", rti.rig.outlet.log_events);
}

/// Returns the position at which the federate closes this connection.
fn closed(recording: &Recording, connection: u16) -> usize {
    let closed = recording.steps.iter().position(|step| *step == Step::Close(connection));
    closed.expect("the recording has such a step")
}

/// Returns the position of the second received message of this connection: the ACK of a federate that authenticates.
fn received_again(recording: &Recording, connection: u16) -> usize {
    let first = received(recording, connection) + 1;
    let is_it = |step: &Step| matches!(step, Step::Recv(frame) if frame.connection == connection);
    first + recording.steps[first..].iter().position(is_it).expect("the recording has such a step")
}
