// SPDX-License-Identifier: Apache-2.0
//! A limit on how far a federate may run ahead of the RTI.
//!
//! Messages that a federate has sent can lie unread in buffers on their way, and a federate without upstream federates
//! receives nothing that would slow it down. Then its answer to a stop request follows thousands of messages, which a
//! receiver that has named a stop tag cannot take. So after some tags with messages a federate sends the RTI a question
//! that every RTI answers in order (module `flow`), when it has taken everything before it. Meanwhile the federate goes
//! on, up to a limit: the window. A federate that offers a larger one than usual asks at the start, too.

use crate::flow::WINDOW;

/// The number of tags with messages that the RTI may not have taken yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlowControl {
    /// Tags with messages since the last question that was answered.
    ahead: u16,
    /// The maximum of them. The queues of network inputs have room for the usual window, and receive buffers for one on
    /// which all have agreed.
    window: u16,
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
    /// Returns the state at the start, of a federate that offers a window or not.
    pub(super) const fn new(offers: bool) -> Self {
        let question = if offers { Question::Due } else { Question::None };
        Self { ahead: 0, window: WINDOW, sending: false, question }
    }

    /// Records that a message of the open tag goes out.
    pub(super) fn message_sent(&mut self) {
        self.sending = true;
    }

    /// Records that the open tag is complete.
    pub(super) fn completed(&mut self) {
        self.ahead = self.ahead.saturating_add(u16::from(core::mem::take(&mut self.sending)));
        if self.question == Question::None {
            self.question = self.next_question();
        }
    }

    /// Returns the question that follows an answer: one is due from half of the window on.
    fn next_question(self) -> Question {
        if self.ahead >= self.window / 2 { Question::Due } else { Question::None }
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

    /// Handles the RTI's answer, with the window from now on.
    pub(super) fn answered(&mut self, window: u16) {
        self.window = window;
        if let Question::Asked(behind) = self.question {
            self.ahead = self.ahead.saturating_sub(behind);
        }
        if self.question != Question::Due {
            self.question = self.next_question();
        }
    }

    /// Returns whether another tag may begin.
    pub(super) fn allows(self) -> bool {
        self.ahead < self.window
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::WINDOW_MAX;
    use proptest::prelude::*;

    fn run(flow_control: &mut FlowControl, tags: u16) {
        for _ in 0..tags {
            flow_control.message_sent();
            flow_control.completed();
        }
    }

    #[test]
    fn few_messages_ask_for_nothing() {
        let mut flow_control = FlowControl::new(false);
        run(&mut flow_control, WINDOW / 2 - 1);
        for _ in 0..100 {
            flow_control.completed();
        }
        assert!(!flow_control.is_question_due() && flow_control.allows());
    }

    #[test]
    fn an_answer_counts_for_what_was_sent_before_the_question() {
        let mut flow_control = FlowControl::new(false);
        run(&mut flow_control, WINDOW / 2);
        assert!(flow_control.is_question_due());
        flow_control.asked();
        run(&mut flow_control, WINDOW / 2);
        assert!(!flow_control.is_question_due() && !flow_control.allows());
        flow_control.answered(WINDOW);
        assert!(flow_control.allows() && flow_control.is_question_due());
        assert_eq!(flow_control.ahead, WINDOW / 2);
    }

    #[test]
    fn an_offer_is_made_before_any_message_and_its_answer_is_the_limit() {
        let mut flow_control = FlowControl::new(true);
        assert!(flow_control.is_question_due());
        flow_control.asked();
        run(&mut flow_control, WINDOW);
        assert!(!flow_control.allows());
        flow_control.answered(100);
        assert!(flow_control.allows() && !flow_control.is_question_due());
        run(&mut flow_control, 100 - WINDOW);
        assert!(!flow_control.allows() && flow_control.is_question_due());
        flow_control.asked();
        flow_control.answered(WINDOW);
        assert!(flow_control.allows() && !flow_control.is_question_due());
    }

    proptest! {
        /// No sequence of steps gets a federate further ahead than the largest window that it was given, and an answer
        /// always lets it go on.
        #[test]
        fn no_federate_runs_away(
            offers: bool,
            steps in proptest::collection::vec((0..4u8, WINDOW..=WINDOW_MAX), 0..200),
        ) {
            let (mut flow_control, mut largest) = (FlowControl::new(offers), WINDOW);
            for (step, window) in steps {
                match step {
                    0 | 1 if flow_control.allows() => run(&mut flow_control, 1),
                    2 if flow_control.is_question_due() => flow_control.asked(),
                    3 => {
                        flow_control.answered(window);
                        largest = largest.max(window);
                    }
                    _ => {}
                }
                prop_assert!(flow_control.ahead <= largest);
                prop_assert!(flow_control.allows() || flow_control.question != Question::None);
            }
            for _ in 0..2 {
                if flow_control.is_question_due() {
                    flow_control.asked();
                }
                flow_control.answered(WINDOW);
            }
            prop_assert!(flow_control.allows());
        }
    }
}
