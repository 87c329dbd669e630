// SPDX-License-Identifier: Apache-2.0
//! A transient federate hands over its state, and takes over what it can of another one.

use std::fmt::Debug;

use crate::support::federation::{Edge, Plan, edge, run_with};
use crate::support::node::{Behavior, FIRED};
use lf_model::time::Interval;
use lf_runtime::platform::{Platform as _, SocketId};
use lf_testkit::world::Blocking;
use lf_wire::{Decoded, HANDED_OVER_PORT, Limits, Message, Tag, decode};

const MS: i64 = 1_000_000;

/// An RTI that this test plays, and its connection to a federate.
struct Played<'a> {
    me: &'a mut Blocking,
    federate: SocketId,
    heard: Vec<u8>,
}

impl Played<'_> {
    fn say(&mut self, message: &Message<'_>) {
        self.me.say(self.federate, message);
    }

    /// Waits for the next message of the federate in which `find` finds something.
    fn hear<T>(&mut self, find: impl Fn(&Message<'_>) -> Option<T>) -> T {
        let limits = Limits { payload_bytes_max: 100, federation_id_bytes_max: 255, neighbors_max: 9 };
        loop {
            let (mut at, mut found) = (0, None);
            while found.is_none()
                && let Ok(Decoded::Complete { message, len }) = decode(&self.heard[at..], &limits)
            {
                at += len;
                found = find(&message);
            }
            self.heard.drain(..at);
            if let Some(found) = found {
                return found;
            }
            let more = self.me.hear_some(self.federate, 256);
            assert!(!more.is_empty(), "the federate has left");
            self.heard.extend(more);
        }
    }

    /// Lets a transient federate in, up to its clock.
    fn let_in(&mut self) {
        self.hear(|message| matches!(message, Message::TransientFedIds { .. }).then_some(()));
        self.say(&Message::Ack);
        let now = self.me.now().as_nanos();
        self.say(&Message::T1(now));
        self.hear(|message| matches!(message, Message::T3 { .. }).then_some(()));
        self.say(&Message::T4(now));
        self.hear(|message| matches!(message, Message::Timestamp(_)).then_some(()));
    }

    /// Passes on a state of another instance.
    fn hand_over(&mut self, bytes: &[u8]) {
        let tag = Tag::new(self.me.now().as_nanos(), 0);
        self.say(&Message::TaggedMessage { port: HANDED_OVER_PORT, federate: 0, tag, payload: bytes });
    }

    /// Returns the next value that the federate sends to another one.
    fn hear_value(&mut self) -> Vec<u8> {
        self.hear(|message| match message {
            Message::TaggedMessage { federate: 1, payload, .. } => Some(payload.to_vec()),
            _ => None,
        })
    }

    /// Begins the incarnation of the federate, 10 ms after the start of the federation, which is returned.
    fn begin(&mut self) -> i64 {
        let start = self.me.now().as_nanos();
        self.say(&Message::EffectiveStart { start, tag: Tag::new(start + 10 * MS, 0) });
        start
    }

    /// Ends the incarnation of the federate. Returns its first value and the states that it hands over.
    fn end(&mut self) -> (Vec<u8>, Vec<Vec<u8>>) {
        let value = self.hear_value();
        self.say(&Message::Stop);
        let mut states = Vec::new();
        while let Some(state) = self.hear(|message| match message {
            Message::TaggedMessage { port: HANDED_OVER_PORT, federate: 0, payload, .. } => Some(Some(payload.to_vec())),
            Message::Resign => Some(None),
            _ => None,
        }) {
            states.push(state);
        }
        (value, states)
    }
}

/// Runs a transient federate with an RTI that `act` plays.
fn with_rti<T: Debug + PartialEq + Send>(
    edges: &[Edge],
    act: impl Fn(&mut Played<'_>) -> T + Sync,
) -> (Vec<String>, T) {
    let counter = Behavior { timer: Some((Interval::ZERO, Interval::from_secs(1))), ..Behavior::default() };
    let nodes = vec![counter, Behavior::default()];
    let plan = Plan { trials: 1, keepalive: true, transients: &[0], ..Plan::new(nodes, edges.to_vec()) };
    let (ran, result) = run_with::<2, _>(&plan, 0, Interval::ZERO, |me, federate| {
        let mut rti = Played { me, federate, heard: Vec::new() };
        rti.let_in();
        let result = act(&mut rti);
        rti.me.platform.close(federate);
        result
    });
    assert_eq!(ran.result, Ok(()), "{:?}", ran.lines);
    (ran.lines, result)
}

/// Returns a state with this id.
fn state(id: u64, value: &[u8]) -> Vec<u8> {
    [&id.to_le_bytes()[..], value].concat()
}

#[test]
fn a_federate_begins_with_the_state_of_another_one_and_hands_over_its_own() {
    let (_, (value, states)) = with_rti(&[edge(0, 1)], |rti| {
        rti.hand_over(&state(FIRED.id, &41u32.to_le_bytes()));
        rti.begin();
        rti.end()
    });
    assert_eq!((value, states), (42u32.to_le_bytes().to_vec(), vec![state(FIRED.id, &42u32.to_le_bytes())]));
}

/// Another build of the program may have other states, with values that are longer than anything here.
#[test]
fn what_does_not_fit_is_not_taken_over_and_said() {
    let long = [0; 5_000];
    let (lines, (value, _)) = with_rti(&[edge(0, 1)], |rti| {
        for state in [&state(1, &[0; 4])[..], &state(FIRED.id, &[0; 5]), &[0; 3], &long, &[]] {
            rti.hand_over(state);
        }
        rti.hand_over(&state(FIRED.id, &7u32.to_le_bytes()));
        rti.hand_over(&long);
        rti.begin();
        rti.end()
    });
    assert_eq!(value, 8u32.to_le_bytes());
    let count = |text: &str| lines.iter().filter(|line| line.contains(text)).count();
    assert_eq!(
        (
            count("which this one does not have"),
            count("`node.fired` is not taken over"),
            count("too long for this one")
        ),
        (3, 1, 2),
        "{lines:?}"
    );
}

/// LF's RTI sends a federate what it sends itself; a state that comes later than the first tag changes nothing either.
#[test]
fn a_state_that_comes_back_changes_nothing() {
    let (_, states) = with_rti(&[edge(0, 1)], |rti| {
        let start = rti.me.now().as_nanos();
        rti.say(&Message::EffectiveStart { start, tag: Tag::new(start, 0) });
        assert_eq!(rti.hear_value(), 1u32.to_le_bytes());
        rti.hand_over(&state(FIRED.id, &99u32.to_le_bytes()));
        let second = rti.hear_value();
        rti.say(&Message::Stop);
        rti.hear(|message| match message {
            Message::TaggedMessage { port: HANDED_OVER_PORT, payload, .. } => Some((second.clone(), payload.to_vec())),
            _ => None,
        })
    });
    assert_eq!(states, (2u32.to_le_bytes().to_vec(), state(FIRED.id, &2u32.to_le_bytes())));
}

/// Others in a cycle without delay wait at a tag before the first one for the word that nothing comes, and the federate
/// takes part afterwards as if nobody had asked.
#[test]
fn what_is_asked_before_the_first_tag_is_answered_and_the_federate_goes_on() {
    let (_, (absent, value)) = with_rti(&[edge(0, 1), edge(1, 0)], |rti| {
        let start = rti.begin();
        rti.say(&Message::ProvisionalTagGrant(Tag::new(start + MS, 0)));
        let absent = rti.hear(|message| match message {
            Message::PortAbsent { federate, tag, .. } => Some((*federate, tag.time - start)),
            _ => None,
        });
        rti.say(&Message::TagGrant(Tag::new(i64::MAX, u32::MAX)));
        (absent, rti.end().0)
    });
    assert_eq!((absent, value), ((1, MS), 1u32.to_le_bytes().to_vec()));
}
