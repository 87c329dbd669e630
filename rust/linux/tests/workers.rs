// SPDX-License-Identifier: Apache-2.0
//! Reactions of one level run at the same time, and what they do is as if they had run one after the other.
#![allow(missing_docs, unreachable_pub, clippy::unwrap_used, reason = "a test program has no users")]

use std::sync::Barrier;
use std::thread::{self, ThreadId};

use lf_linux::Threads;
use lf_linux::model::*;
use lf_linux::runtime::UnfederatedLoop;

const COUNT: usize = 4;

/// Three reactors that meet, and one with a deadline that is always missed, all triggered by one timer; and one that
/// sees what they have set, at the next level.
const TABLES: Tables = Tables {
    reactions: &[
        ReactionInfo { name: "one", ..ReactionInfo::DEFAULT },
        ReactionInfo { name: "two", ..ReactionInfo::DEFAULT },
        ReactionInfo { name: "three", ..ReactionInfo::DEFAULT },
        ReactionInfo { name: "four", deadline: Some(Interval::ZERO), ..ReactionInfo::DEFAULT },
        ReactionInfo { name: "sink", level: 1, ..ReactionInfo::DEFAULT },
        ReactionInfo { name: "again", level: 1, ..ReactionInfo::DEFAULT },
    ],
    triggers: &[
        TriggerInfo {
            name: "t",
            kind: TriggerKind::Timer { offset: Interval::ZERO, period: Interval::ZERO },
            reactions: &[ReactionId(0), ReactionId(1), ReactionId(2), ReactionId(3)],
        },
        TriggerInfo { name: "again", kind: TriggerKind::Logical(ActionTiming::NONE), reactions: &[ReactionId(5)] },
    ],
    ports: &[
        PortInfo { name: "one", reactions: &[ReactionId(4)], delays: &[] },
        PortInfo { name: "two", reactions: &[ReactionId(4)], delays: &[] },
        PortInfo { name: "three", reactions: &[ReactionId(4)], delays: &[] },
    ],
    workers: 4,
    ..Tables::DEFAULT
};
const _: () = TABLES.check();

/// All who run at the first level.
static MEETING: Barrier = Barrier::new(COUNT);

struct Shared {
    one: Port<u32>,
    two: Port<u32>,
    three: Port<u32>,
    again: LogicalActionQueue<u32, 1>,
    /// The threads in which the reactions of the first level ran.
    threads: [Option<ThreadId>; COUNT],
    workers: usize,
    sums: Vec<u32>,
    again_at: Option<EventTag>,
}

fn meet(thread: &mut Option<ThreadId>) {
    MEETING.wait();
    *thread = Some(thread::current().id());
}

impl Program for Shared {
    fn tables(&self) -> &'static Tables {
        &TABLES
    }

    fn react(&mut self, reaction: ReactionId, ctx: &mut ReactionContext<'_>) {
        match reaction {
            ReactionId(4) => {
                let ports = [&self.one, &self.two, &self.three];
                self.sums.push(ports.into_iter().filter_map(|port| ctx.get(port)).sum());
            }
            ReactionId(5) => self.again_at = Some(ctx.get_tag()),
            _ => panic!("a reaction of the first level runs by itself"),
        }
    }

    fn share(&mut self, number: u16, level: &mut Level<'_>) {
        let [first, second, third, fourth] = &mut self.threads;
        if number != 0 {
            return;
        }
        level.run::<COUNT, { TABLES.note_words() }>(
            &Threads::<COUNT>,
            &mut [
                Job::new(&[ReactionId(0)], &[TriggerId(1)], &mut |_, part, ctx| {
                    meet(first);
                    assert_eq!(part, Part::Body);
                    self.workers = ctx.num_workers();
                    ctx.set(&mut self.one, 1);
                    let again: &mut LogicalAction<u32> = &mut self.again;
                    ctx.schedule(again, Offset::Asap);
                }),
                Job::new(&[ReactionId(1)], &[], &mut |_, _, ctx| {
                    meet(second);
                    ctx.set(&mut self.two, 20);
                }),
                Job::new(&[ReactionId(2)], &[], &mut |_, _, ctx| {
                    meet(third);
                    ctx.set(&mut self.three, 300);
                    ctx.request_stop(Offset::After(std::time::Duration::ZERO));
                }),
                Job::new(&[ReactionId(3)], &[], &mut |_, part, _| {
                    meet(fourth);
                    assert_eq!(part, Part::MissedDeadline);
                }),
            ],
        );
    }

    fn port(&mut self, port: PortId) -> Option<&mut dyn PortCell> {
        match port {
            PortId(0) => Some(&mut self.one),
            PortId(1) => Some(&mut self.two),
            PortId(2) => Some(&mut self.three),
            _ => None,
        }
    }

    fn trigger(&mut self, trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        match trigger {
            TriggerId(1) => Some(&mut self.again),
            _ => None,
        }
    }
}

/// No reaction of the first level ends before all four have begun.
#[test]
fn reactions_of_a_level_run_in_as_many_threads_as_there_are_workers() {
    let mut program = Shared {
        one: Port::new(PortId(0)),
        two: Port::new(PortId(1)),
        three: Port::new(PortId(2)),
        again: LogicalActionQueue::new(TriggerId(1)),
        threads: [None; COUNT],
        workers: 0,
        sums: Vec::new(),
        again_at: None,
    };
    let mut storage = Storage::<2, 1, 1, 1>::new();
    let engine = Engine::new(&TABLES, &mut storage, Settings { fast: true, ..Settings::DEFAULT });
    let mut host = lf_linux::Linux::new().unwrap();
    UnfederatedLoop::new(&mut host, &mut program, engine).run().unwrap();
    let mut threads: Vec<_> = program.threads.iter().flatten().map(|thread| format!("{thread:?}")).collect();
    threads.sort();
    threads.dedup();
    assert_eq!(threads.len(), COUNT);
    assert!(program.threads.contains(&Some(thread::current().id())), "the event loop works, too");
    assert_eq!((program.workers, program.sums), (COUNT, vec![321]));
    assert_eq!(program.again_at.map(|tag| (tag.offset_from_t0, tag.microstep)), Some((std::time::Duration::ZERO, 1)));
}
