// SPDX-License-Identifier: Apache-2.0
//! The RTI answers federates that come and go as the RTI in the recordings of LF 0.13 did, but for what is better on
//! purpose. Each difference is an edit of the recording, with its reason.

use lf_coordination::rti::{Outcome, Status};
use lf_testkit::golden::replay::replay;
use lf_testkit::golden::{Frame, Recording, Step, load};
use lf_testkit::messages::encoded;
use lf_testkit::rti::Recorded;
use lf_wire::{KIND_TRANSIENT, Message, NeighborStructure, RejectCode, Tag, UDP_PORT_CLOCK_SYNC_OFF};

/// The start time of the recordings that are edited.
const START: i64 = 1_000_000_001_000_000_000;
const MS: i64 = 1_000_000;
const ID: &[u8] = b"Unidentified Federation";

/// A change of a recording, at the index of a step in its file.
enum Edit {
    /// This message to this connection comes after the step.
    After(usize, u16, Message<'static>),
    /// The step has this message instead of its own.
    Instead(usize, Message<'static>),
    /// Nothing comes there.
    Without(usize),
    /// The recording ends before this step, and goes on with these.
    Then(usize, Vec<Step>),
}

use Edit::{After, Instead, Then, Without};

fn tag(ms: i64, microstep: u32) -> Tag {
    Tag::new(START + ms * MS, microstep)
}

/// Returns the tag just before this time.
fn before(ms: i64) -> Tag {
    Tag::new(START + ms * MS - 1, u32::MAX)
}

fn granted(tag: Tag) -> Message<'static> {
    Message::TagGrant(tag)
}

fn begins(ms: i64, microstep: u32) -> Message<'static> {
    Message::EffectiveStart { start: START, tag: tag(ms, microstep) }
}

const ENDLESS: Message<'static> = Message::TagGrant(Tag::FOREVER);
const TOO_LATE: Message<'static> = Message::Reject(RejectCode::JoinsTooLate);

fn frame(connection: u16, message: &Message<'_>) -> Frame {
    let hex = encoded(message).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
    let bytes = hex.parse().expect("it is hexadecimal");
    Frame { connection, bytes, fill: None, tag: None, message: message.name().to_owned(), note: None }
}

fn sent(connection: u16, message: &Message<'_>) -> Step {
    Step::Send(frame(connection, message))
}

fn received(connection: u16, message: &Message<'_>) -> Step {
    Step::Recv(frame(connection, message))
}

/// Returns the steps by which a transient federate joins, up to its clock at this time.
fn joins(connection: u16, federate: u16, upstream: &[(u16, i64)], clock_ms: i64) -> Vec<Step> {
    vec![
        Step::Connect(connection),
        sent(connection, &Message::TransientFedIds { federate, kind: KIND_TRANSIENT, federation_id: ID }),
        received(connection, &Message::Ack),
        sent(connection, &Message::NeighborStructure(NeighborStructure::new(upstream, &[]))),
        sent(connection, &Message::UdpPort(UDP_PORT_CLOCK_SYNC_OFF)),
        sent(connection, &Message::Timestamp(START + clock_ms * MS)),
    ]
}

fn edited(name: &str, edits: Vec<Edit>) -> Recording {
    let mut recording = load(&format!("0.13/{name}")).unwrap_or_else(|error| panic!("{error}"));
    let mut steps: Vec<Vec<Step>> = recording.steps.into_iter().map(|step| vec![step]).collect();
    for edit in edits {
        match edit {
            After(at, connection, message) => steps[at].push(received(connection, &message)),
            Instead(at, message) => {
                let Step::Recv(own) = &steps[at][0] else { panic!("{name}: step {at} receives nothing") };
                steps[at][0] = received(own.connection, &message);
            }
            Without(at) => steps[at].clear(),
            Then(at, more) => {
                steps.truncate(at);
                steps.push(more);
            }
        }
    }
    recording.steps = steps.concat();
    recording
}

fn play(recording: &Recording) -> Vec<Recorded> {
    // Whole, and in pieces that cut every message.
    let pieces = [usize::MAX, 1, 7].into_iter();
    let played = pieces.map(|piece| {
        let mut rti = Recorded::new(recording.rti().expect("it is the recording of an RTI"), piece);
        if let Err(difference) = replay(recording, &mut rti) {
            panic!("{difference}\n{:#?}", rti.rig.outlet.log_events);
        }
        rti
    });
    played.collect()
}

/// Plays a recording with these differences, after which the federation is over.
fn play_edited(name: &str, edits: Vec<Edit>) {
    let failed = matches!(name, "13-leaves-by-failed" | "42-outbound-notices");
    for rti in play(&edited(name, edits)) {
        let Status::Finished(outcome) = rti.rig.rti.status() else { panic!("{name}: the federation is not over") };
        let lost = matches!(outcome, Outcome::Lost { .. });
        // In 02 a persistent federate closes its connection without a word.
        assert_eq!(lost, failed || name == "02-persistent-upstreams-gone", "{name}: {outcome}");
    }
}

/// Plays a recording with these differences, which ends while the federation goes on.
fn play_on(name: &str, edits: Vec<Edit>) {
    play(&edited(name, edits));
}

fn play_as_it_is(name: &str) {
    play_edited(name, Vec::new());
}

lf_testkit::recordings! {
    play_as_it_is;
    present_from_the_start: "04-present-from-the-start",
    absent_at_the_start: "05-absent-at-the-start",
    joins_in_the_past: "07-joins-in-the-past",
    delayed_grants: "08-delayed-grants",
    join_cancels_delayed_grant: "09-join-cancels-delayed-grant",
    hot_swap: "15-hot-swap",
    dnet_only_downstream_absent: "20b-dnet-only-downstream-absent",
    messages_to_absent: "22-messages-to-absent",
    stop_while_absent: "26-stop-while-absent",
    joining_too_late: "30-joining-too-late",
    rejections_while_running: "34-rejections-while-running",
    start_barrier: "38-start-barrier",
    after: "40-after",
}

/// A federate whose upstream federates have all left for good is granted all tags at once, and not its own NETs one by
/// one. A persistent one that vanishes holds nobody up.
#[test]
fn who_waits_for_nobody_is_free() {
    play_edited("01-persistent-address-query", vec![After(35, 1, ENDLESS)]);
    let freed = vec![After(28, 2, granted(before(30))), Instead(38, ENDLESS), Without(40), Without(42)];
    play_edited("02-persistent-upstreams-gone", freed);
    play_edited("03-persistent-by-103", vec![After(20, 1, ENDLESS)]);
    play_edited("11-leaves-by-resign-and-returns", vec![After(98, 1, ENDLESS)]);
    play_edited("27-stop-by-transient", vec![Instead(61, ENDLESS)]);
    let freed = vec![Instead(46, ENDLESS), Without(48), Without(55), Without(58)];
    play_edited("37-all-persistents-gone", freed);
    play_edited("44-clock-sync-late-joiner", vec![Instead(34, ENDLESS)]);
}

/// A transient federate counts with its effective start until its first NET, and not with the start of the federation:
/// nothing earlier can come from it, and nothing earlier matters to it.
#[test]
fn who_has_come_counts_with_its_effective_start() {
    play_edited("06-joins-late", vec![Without(36), After(35, 2, granted(before(20)))]);
    play_edited("19-chain-of-transients", vec![]);
    let at = Message::ProvisionalTagGrant(tag(20, 0));
    let known = granted(tag(30, 0));
    let cycle = vec![
        After(20, 0, at),
        Instead(21, at),
        Without(23),
        Without(24),
        After(35, 0, known),
        After(36, 1, known),
        // Who is told that another one has left, and waits at a PTAG, is granted the tag, too.
        After(45, 0, granted(tag(40, 0))),
    ];
    play_edited("21-zero-delay-cycle", cycle);
}

/// Those downstream of a federate whose connection ends are told, and granted what they wait for.
#[test]
fn who_vanishes_has_left() {
    let told = Message::UpstreamDisconnected { federate: 1 };
    play_edited("12-leaves-by-closing", vec![After(43, 2, told), After(43, 2, granted(tag(200, 0))), Without(48)]);
    play_edited("42-outbound-notices", vec![After(46, 0, Message::OutboundDisconnected { federate: 1 })]);
}

/// FAILED ends an incarnation as RESIGN does, and frees the place for the next instance.
#[test]
fn who_fails_leaves_nothing_behind() {
    let dnet = Message::DownstreamNextEventTag;
    play_edited(
        "13-leaves-by-failed",
        vec![
            Without(50),
            Instead(61, dnet(tag(300, 1))),
            After(60, 1, dnet(tag(400, 0))),
            After(62, 0, dnet(tag(400, 0))),
        ],
    );
    play_on("16b-hot-swap-old-fails", vec![After(25, 101, begins(10, 0)), After(27, 101, granted(before(20)))]);
}

/// Nobody is granted FOREVER while a federate upstream may come back.
#[test]
fn who_returns_after_the_end_of_its_events_can_act() {
    play_edited(
        "14-returns-after-forever",
        vec![Instead(26, granted(tag(50, 0))), After(31, 1, granted(tag(60, 0))), Instead(38, begins(100, 0))],
    );
}

/// An effective start is after all that the federate did before, and after the grants downstream, not later.
#[test]
fn an_effective_start_is_neither_too_early_nor_too_late() {
    play_edited("18-hot-swap-completed", vec![Instead(31, begins(100, 1)), Instead(37, ENDLESS)]);
    play_edited(
        "25-in-transit-and-effective-start",
        vec![Instead(27, begins(1000, 0)), After(32, 0, ENDLESS), Instead(36, ENDLESS)],
    );
    play_edited("47-effective-start-wraps", vec![Instead(24, begins(10, 0))]);
}

/// Transient federates may be upstream of each other from the start on.
#[test]
fn a_chain_of_transients_starts() {
    let clock = |connection| sent(connection, &Message::Timestamp(START - 1000 * MS));
    let starts = vec![
        clock(1),
        clock(2),
        clock(3),
        clock(0),
        received(0, &Message::Timestamp(START)),
        received(1, &begins(0, 0)),
        received(2, &begins(0, 0)),
        received(2, &Message::UpstreamConnected { federate: 1 }),
        received(3, &Message::Timestamp(START)),
        received(3, &Message::UpstreamConnected { federate: 2 }),
    ];
    play_on("19b-chain-of-transients-at-start", vec![Then(20, starts)]);
}

/// An absent federate is no reason to wait with a PTAG.
#[test]
fn a_cycle_below_an_absent_federate_goes_on() {
    let at = |ms| Message::ProvisionalTagGrant(tag(ms, 0));
    let moves = vec![
        After(14, 1, at(0)),
        After(23, 2, granted(tag(0, 0))),
        After(25, 1, at(10)),
        Instead(34, begins(10, 1)),
        Without(37),
        After(42, 2, granted(tag(10, 0))),
        After(54, 2, ENDLESS),
    ];
    play_edited("21b-zero-delay-cycle-below-absent", moves);
}

/// A message before the effective start is dropped, and its sender is not held up.
#[test]
fn what_comes_too_early_is_dropped() {
    play_edited("23-message-before-effective-start-after", vec![Without(18), Without(20), After(25, 1, ENDLESS)]);
    let dnet = Message::DownstreamNextEventTag(tag(1000, 0));
    let early = vec![Without(18), After(19, 0, dnet), Without(20), After(23, 1, ENDLESS)];
    play_edited("24-message-between-handshake-and-timestamp", early);
}

/// A stop waits for all that take part, and nobody joins after it.
#[test]
fn a_stop_is_one_of_all() {
    let mut late: Vec<_> = (25..=35).map(Without).collect();
    late.push(Instead(24, TOO_LATE));
    let mut recording = edited("26b-join-after-stop-granted", late);
    let refused = recording.steps.iter().position(|step| *step == received(1, &TOO_LATE));
    let at = refused.expect("it was put there") + 1;
    recording.steps.splice(at..at, [Step::ClosedByPeer(1), Step::Close(1)]);
    play(&recording);
    let stop = Message::StopGranted(tag(150, 0));
    play_edited(
        "28b-stop-transient-answers-late",
        vec![
            Without(47),
            Without(48),
            Without(49),
            After(50, 0, stop),
            After(50, 1, stop),
            After(50, 2, stop),
            Instead(54, ENDLESS),
            Instead(59, granted(tag(150, 0))),
        ],
    );
}

/// A federate that cannot join learns it at once, and the others go on.
#[test]
fn who_cannot_join_disturbs_nobody() {
    let late = vec![
        received(101, &TOO_LATE),
        Step::ClosedByPeer(101),
        Step::Close(101),
        sent(2, &Message::Resign),
        Step::ClosedByPeer(2),
        Step::Close(2),
    ];
    play_edited("31-persistent-too-late", vec![Then(22, late)]);
    let in_use = vec![
        received(100, &Message::Reject(RejectCode::IdInUse)),
        Step::ClosedByPeer(100),
        Step::Close(100),
        sent(1, &Message::NextEventTag(tag(12, 0))),
        received(0, &Message::DownstreamNextEventTag(tag(12, 0))),
    ];
    play_on("32-persistent-id-claimed", vec![Then(18, in_use)]);
    play_on("33-transient-id-claimed", vec![After(21, 1, granted(before(20)))]);
    let mut joined = joins(1, 1, &[(0, lf_wire::DELAY_NONE)], 5);
    joined.push(received(1, &begins(5, 0)));
    play_on("35-joiner-gone-in-handshake", vec![Then(12, joined)]);
}

/// A federate that has joined and not sent its clock holds nobody up.
#[test]
fn who_is_not_ready_is_absent() {
    play_on(
        "39b-net-between-handshake-and-timestamp",
        vec![After(12, 1, granted(tag(0, 0))), Without(16), Without(17), Without(19)],
    );
}
