// SPDX-License-Identifier: Apache-2.0
//! A limit on how far a federate may run ahead of the RTI.
//!
//! Messages that a federate has sent can lie unread in buffers on their way, and a federate without upstream federates
//! receives nothing that would slow it down. Then its answer to a stop request follows thousands of messages, which a
//! receiver that has named a stop tag cannot take. So after some tags with messages a federate sends the RTI a question
//! that every RTI answers in order: a `PORT_ABSENT` for itself, which comes back when the RTI has taken everything
//! before it. Meanwhile the federate goes on, up to a limit. The question names an input that does not exist and a tag
//! at which nothing happens, so it has no other meaning.

use lf_wire::{Message, Tag};

use crate::FederateId;

/// The input that a question names.
const NO_INPUT: u16 = u16::MAX;

/// The number of tags with messages after which the federate asks the RTI.
const ASK_AFTER: u16 = 8;
/// The maximum number of tags with messages that a federate begins before the RTI has answered. The queues of network
/// inputs have room for these.
pub const TAGS_AHEAD_MAX: u16 = 16;

/// The number of tags with messages that the RTI may not have taken yet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FlowControl {
    /// Tags with messages since the last question that was answered.
    ahead: u16,
    /// The tag that is open has messages.
    sending: bool,
    question: Question,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Question {
    #[default]
    None,
    Due,
    /// It follows the messages of this many tags.
    Asked(u16),
}

impl FlowControl {
    /// Records that a message of the open tag goes out.
    pub(super) fn message_sent(&mut self) {
        self.sending = true;
    }

    /// Records that the open tag is complete.
    pub(super) fn completed(&mut self) {
        self.ahead += u16::from(core::mem::take(&mut self.sending));
        if self.ahead >= ASK_AFTER && self.question == Question::None {
            self.question = Question::Due;
        }
    }

    /// Returns the question for the RTI, which the RTI sends back.
    pub(super) const fn question(federate: FederateId) -> Message<'static> {
        Message::PortAbsent { port: NO_INPUT, federate: federate.0, tag: Tag::NEVER }
    }

    /// Returns whether a message is the answer to such a question of this federate.
    pub(super) fn is_answer(message: &Message<'_>, own: FederateId) -> bool {
        matches!(*message, Message::PortAbsent { port: NO_INPUT, federate, tag: Tag::NEVER } if federate == own.0)
    }

    /// Returns whether a question is due.
    pub(super) fn is_question_due(self) -> bool {
        self.question == Question::Due
    }

    /// Returns whether the RTI owes an answer.
    pub(super) fn is_asked(self) -> bool {
        matches!(self.question, Question::Asked(_))
    }

    /// Records that the question is sent.
    pub(super) fn asked(&mut self) {
        self.question = Question::Asked(self.ahead);
    }

    /// Handles the RTI's answer.
    pub(super) fn answered(&mut self) {
        if let Question::Asked(behind) = self.question {
            self.ahead = self.ahead.saturating_sub(behind);
            self.question = if self.ahead >= ASK_AFTER { Question::Due } else { Question::None };
        }
    }

    /// Returns whether another tag may begin.
    pub(super) fn allows(self) -> bool {
        self.ahead < TAGS_AHEAD_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn run(flow_control: &mut FlowControl, tags: u16) {
        for _ in 0..tags {
            flow_control.message_sent();
            flow_control.completed();
        }
    }

    #[test]
    fn few_messages_ask_for_nothing() {
        let mut flow_control = FlowControl::default();
        run(&mut flow_control, ASK_AFTER - 1);
        for _ in 0..100 {
            flow_control.completed();
        }
        assert!(!flow_control.is_question_due() && flow_control.allows());
    }

    #[test]
    fn an_answer_counts_for_what_was_sent_before_the_question() {
        let mut flow_control = FlowControl::default();
        run(&mut flow_control, ASK_AFTER);
        assert!(flow_control.is_question_due());
        flow_control.asked();
        run(&mut flow_control, TAGS_AHEAD_MAX - ASK_AFTER);
        assert!(!flow_control.is_question_due() && !flow_control.allows());
        flow_control.answered();
        assert!(flow_control.allows() && flow_control.is_question_due());
        assert_eq!(flow_control.ahead, TAGS_AHEAD_MAX - ASK_AFTER);
    }

    proptest! {
        /// No sequence of steps gets a federate further ahead than the limit, and an answer always lets it go on.
        #[test]
        fn no_federate_runs_away(steps in proptest::collection::vec(0..4u8, 0..200)) {
            let mut flow_control = FlowControl::default();
            for step in steps {
                match step {
                    0 | 1 if flow_control.allows() => run(&mut flow_control, 1),
                    2 if flow_control.is_question_due() => flow_control.asked(),
                    3 => flow_control.answered(),
                    _ => {}
                }
                prop_assert!(flow_control.ahead <= TAGS_AHEAD_MAX);
                prop_assert!(flow_control.allows() || flow_control.question != Question::None);
            }
            if flow_control.is_question_due() {
                flow_control.asked();
            }
            flow_control.answered();
            prop_assert!(flow_control.allows());
        }
    }
}
