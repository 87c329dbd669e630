// SPDX-License-Identifier: Apache-2.0
//! Dialogues with a federate that offers a window. Images offer none.

use super::config;
use crate::federate_support::dialogue::{DOWNSTREAM, NOW, drain, ms, started};
use lf_coordination::WINDOW;
use lf_testkit::rti::dialogue::flow;

/// A federate with memory for more offers a larger window at the start, and with each question again. It uses the one
/// that the RTI names, or the usual one where an RTI just sends the offer back.
#[test]
fn a_source_goes_as_far_ahead_as_the_rti_allows() {
    for (answer, window) in [(flow(u16::MAX - 1, 1, 40), 40), (flow(u16::MAX, 1, 100), i64::from(WINDOW))] {
        let mut federate = started(lf_coordination::federate::Config { window: 100, ..config(&[], DOWNSTREAM) });
        assert_eq!(drain(&mut federate), [flow(u16::MAX, 1, 100)]);
        federate.handle_message(NOW, answer).expect("it is an answer");
        let mut sent = Vec::new();
        let mut tags = 0;
        while federate.next_event(NOW, ms(tags)) {
            federate.begin(ms(tags)).expect("it may begin");
            federate.sent();
            federate.complete(false);
            sent.extend(drain(&mut federate));
            tags += 1;
        }
        assert_eq!(tags, window);
        assert_eq!(sent.iter().filter(|message| **message == flow(u16::MAX, 1, 100)).count(), 1);
    }
}
