// SPDX-License-Identifier: Apache-2.0
//! How far a federate may run ahead of what the RTI has taken from it.
//!
//! What a federate has sent can lie unread in buffers on its way, and a federate without upstream federates hears of
//! nothing that would slow it down. Then its answer to a stop request lies behind thousands of messages, which a
//! receiver that has named a stop tag cannot take. So after some tags with messages a federate sends the RTI a question
//! that every RTI answers in order: a `PORT_ABSENT` for itself, which comes back when everything before it has been
//! taken. Meanwhile the federate goes on, but not far. The question names an input that nobody has and a tag at which
//! nothing happens, so it means nothing else to anybody.

use lf_wire::{Message, Tag};

use crate::FederateId;

/// The input that a question names.
const NO_INPUT: u16 = u16::MAX;

/// After so many tags with messages the RTI is asked.
const ASK_AFTER: u16 = 8;
/// How many tags with messages a federate begins at most before the RTI has answered. The queues of network inputs
/// have room for these.
pub const TAGS_AHEAD_MAX: u16 = 16;

/// What has been sent, and how much of it is known to have been taken.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
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
    /// It stands behind the messages of so many tags.
    Asked(u16),
}

impl Pace {
    /// A message of the open tag goes out.
    pub(super) fn message_sent(&mut self) {
        self.sending = true;
    }

    /// The open tag is complete.
    pub(super) fn completed(&mut self) {
        self.ahead += u16::from(core::mem::take(&mut self.sending));
        if self.ahead >= ASK_AFTER && self.question == Question::None {
            self.question = Question::Due;
        }
    }

    /// What a federate asks the RTI, and gets back.
    pub(super) const fn question(federate: FederateId) -> Message<'static> {
        Message::PortAbsent { port: NO_INPUT, federate: federate.0, tag: Tag::NEVER }
    }

    /// Whether a message is the answer to such a question of this federate.
    pub(super) fn is_answer(message: &Message<'_>, own: FederateId) -> bool {
        matches!(*message, Message::PortAbsent { port: NO_INPUT, federate, tag: Tag::NEVER } if federate == own.0)
    }

    /// Whether the RTI is to be asked.
    pub(super) fn is_question_due(self) -> bool {
        self.question == Question::Due
    }

    /// Whether the RTI owes an answer.
    pub(super) fn is_asked(self) -> bool {
        matches!(self.question, Question::Asked(_))
    }

    /// The RTI is being asked.
    pub(super) fn asked(&mut self) {
        self.question = Question::Asked(self.ahead);
    }

    /// The RTI has answered.
    pub(super) fn answered(&mut self) {
        if let Question::Asked(behind) = self.question {
            self.ahead = self.ahead.saturating_sub(behind);
            self.question = if self.ahead >= ASK_AFTER { Question::Due } else { Question::None };
        }
    }

    /// Whether another tag may be begun.
    pub(super) fn allows(self) -> bool {
        self.ahead < TAGS_AHEAD_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn run(pace: &mut Pace, tags: u16) {
        for _ in 0..tags {
            pace.message_sent();
            pace.completed();
        }
    }

    #[test]
    fn few_messages_ask_for_nothing() {
        let mut pace = Pace::default();
        run(&mut pace, ASK_AFTER - 1);
        for _ in 0..100 {
            pace.completed();
        }
        assert!(!pace.is_question_due() && pace.allows());
    }

    #[test]
    fn an_answer_counts_for_what_was_sent_before_the_question() {
        let mut pace = Pace::default();
        run(&mut pace, ASK_AFTER);
        assert!(pace.is_question_due());
        pace.asked();
        run(&mut pace, TAGS_AHEAD_MAX - ASK_AFTER);
        assert!(!pace.is_question_due() && !pace.allows());
        pace.answered();
        assert!(pace.allows() && pace.is_question_due());
        assert_eq!(pace.ahead, TAGS_AHEAD_MAX - ASK_AFTER);
    }

    proptest! {
        /// Whatever happens, nobody gets further ahead than the limit, and an answer always lets it go on.
        #[test]
        fn nobody_runs_away(steps in proptest::collection::vec(0..4u8, 0..200)) {
            let mut pace = Pace::default();
            for step in steps {
                match step {
                    0 | 1 if pace.allows() => run(&mut pace, 1),
                    2 if pace.is_question_due() => pace.asked(),
                    3 => pace.answered(),
                    _ => {}
                }
                prop_assert!(pace.ahead <= TAGS_AHEAD_MAX);
                prop_assert!(pace.allows() || pace.question != Question::None);
            }
            if pace.is_question_due() {
                pace.asked();
            }
            pace.answered();
            prop_assert!(pace.allows());
        }
    }
}
