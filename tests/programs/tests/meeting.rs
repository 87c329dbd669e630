// SPDX-License-Identifier: Apache-2.0
//! Reactions of one level run at the same time, and what they do is as if they had run one after the other.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use std::thread;
use std::time::Duration;

use lf_linux::model::{Engine, EngineStorage as _, EventTag, Settings};
use lf_linux::runtime::UnfederatedLoop;
use lf_programs::meeting::Meeting::federate::{MeetingMain, Storage, TABLES};
use lf_programs::meeting::Meeting::meeting::{AGAIN_AT, SUMS, THREADS};

/// No reaction of the first level ends before all four have begun.
#[test]
fn reactions_of_a_level_run_in_as_many_threads_as_there_are_workers() {
    let (mut program, mut storage) = (MeetingMain::new(), Storage::new());
    let engine = Engine::new(&TABLES, &mut storage, Settings { fast: true, ..Settings::DEFAULT });
    UnfederatedLoop::new(&mut lf_linux::Linux::new().unwrap(), &mut program, engine).run().unwrap();
    let mut threads: Vec<_> = THREADS.lock().unwrap().iter().map(|thread| format!("{thread:?}")).collect();
    threads.sort();
    threads.dedup();
    assert_eq!(threads.len(), 4);
    assert!(THREADS.lock().unwrap().contains(&thread::current().id()), "the event loop works, too");
    assert_eq!(*SUMS.lock().unwrap(), [321]);
    assert_eq!(*AGAIN_AT.lock().unwrap(), Some(EventTag::new(Duration::ZERO, 1)));
}
