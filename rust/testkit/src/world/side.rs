// SPDX-License-Identifier: Apache-2.0
//! The time of one participant, and the threads that its program starts.
//!
//! A participant's time runs ahead of the world's while its event loop computes. Its threads act within that span, each
//! at its time, so that the loop finds the results when it looks.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::time::Instant;
use lf_model::{Mailbox, Outside};

use super::lock::lock;

/// The time of every participant's clock at the beginning, before its own offset.
const EPOCH_NS: i64 = 1_000_000_000_000;

/// The state that the threads of a participant share with its event loop: its clock, and the access to its program. All
/// times are nanoseconds.
#[derive(Debug)]
pub struct Side {
    /// Virtual time, as far as this participant has advanced.
    time: AtomicU64,
    /// The number of reactions that have run.
    reactions: AtomicU64,
    clock_offset: i64,
    clock_drift_ppb: i64,
    /// The corrections of its clock, each with the virtual time from which on it applies.
    corrections: Mutex<Vec<(u64, ClockCorrection)>>,
    mailbox: Mailbox,
    woken: AtomicBool,
    threads: Mutex<Vec<Thread>>,
}

/// A thread of a program, which acts at times that are known in advance.
pub struct Thread {
    act: Box<dyn FnMut(usize) + Send>,
    /// The times of its actions: after its start at first, then in virtual time.
    times: VecDeque<u64>,
}

impl Thread {
    /// Returns a thread that acts at these times after its start; `act` gets the number of actions that are left.
    pub fn new(times: &[i64], act: impl FnMut(usize) + Send + 'static) -> Self {
        Self { act: Box::new(act), times: times.iter().map(|ns| ns.unsigned_abs()).collect() }
    }

    fn act(&mut self) {
        self.times.pop_front();
        (self.act)(self.times.len());
    }
}

impl fmt::Debug for Thread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Thread").field("times", &self.times).finish_non_exhaustive()
    }
}

impl Side {
    /// Returns a participant whose clock is ahead by `clock_offset` at the beginning, and has this drift.
    pub fn keep(clock_offset: i64, clock_drift_ppb: i64) -> &'static Self {
        Box::leak(Box::new(Self {
            time: AtomicU64::new(0),
            reactions: AtomicU64::new(0),
            clock_offset,
            clock_drift_ppb,
            corrections: Mutex::new(Vec::new()),
            mailbox: Mailbox::new(),
            woken: AtomicBool::new(false),
            threads: Mutex::new(Vec::new()),
        }))
    }

    /// Returns the virtual time, as far as this participant has advanced.
    pub fn now(&self) -> u64 {
        self.time.load(Ordering::Relaxed)
    }

    /// Counts a reaction, and spends this much virtual time on it, in which the event loop sees no input.
    pub fn work(&self, ns: u64) {
        self.reactions.fetch_add(1, Ordering::Relaxed);
        self.compute(ns);
    }

    /// Returns the number of reactions that have run.
    pub fn reactions(&self) -> u64 {
        self.reactions.load(Ordering::Relaxed)
    }

    /// Spends this much virtual time, in which the event loop sees no input.
    pub fn compute(&self, ns: u64) {
        self.advance_to(self.now().saturating_add(ns));
    }

    /// Advances to this virtual time, if it is later; threads act on the way.
    pub fn advance_to(&self, time: u64) {
        while let Some(at) = self.next_act().filter(|at| *at <= time) {
            self.time.fetch_max(at, Ordering::Relaxed);
            let mut threads = lock(&self.threads);
            let due = threads.iter().position(|thread| thread.times.front() == Some(&at));
            if let Some(index) = due {
                threads[index].act();
                if threads[index].times.is_empty() {
                    threads.remove(index);
                }
            }
        }
        self.time.fetch_max(time, Ordering::Relaxed);
    }

    /// Returns the time at which a thread acts next.
    pub fn next_act(&self) -> Option<u64> {
        lock(&self.threads).iter().filter_map(|thread| thread.times.front().copied()).min()
    }

    /// Starts a thread now.
    pub fn start(&self, mut thread: Thread) {
        let now = self.now();
        for time in &mut thread.times {
            *time += now;
        }
        if !thread.times.is_empty() {
            lock(&self.threads).push(thread);
        }
    }

    /// Ends the program and its threads.
    pub fn end(&self) {
        lock(&self.threads).clear();
    }

    /// Returns whether the event loop was woken since the last call.
    pub fn take_woken(&self) -> bool {
        self.woken.swap(false, Ordering::Relaxed)
    }

    /// Applies a correction to its clock from now on.
    pub fn set_correction(&self, correction: ClockCorrection) {
        lock(&self.corrections).push((self.now(), correction));
    }

    /// Returns the federation's physical time at a virtual time, as this participant sees it.
    pub fn physical_at(&self, time: u64) -> Instant {
        let corrections = lock(&self.corrections);
        let correction = corrections.iter().rev().find(|(from, _)| *from <= time).map(|(_, correction)| *correction);
        correction.unwrap_or(ClockCorrection::NONE).physical(self.local_at(time))
    }

    /// Returns the time of its clock.
    pub fn local(&self) -> Instant {
        self.local_at(self.now())
    }

    fn local_at(&self, time: u64) -> Instant {
        let time = i64::try_from(time).unwrap_or(i64::MAX);
        let drift = i128::from(time) * i128::from(self.clock_drift_ppb) / 1_000_000_000;
        Instant::from_nanos(EPOCH_NS + self.clock_offset + time + i64::try_from(drift).unwrap_or(0))
    }

    /// Returns the virtual time at which its clock shows a deadline; `None` for never.
    pub fn virtual_time(&self, deadline: Deadline) -> Option<u64> {
        let now = self.now();
        let at = match deadline {
            Deadline::Now => return Some(now),
            Deadline::Never => return None,
            Deadline::At(at) => at,
        };
        let mut time = now;
        // A few iterations suffice for a clock with a small drift.
        loop {
            let left = at.as_nanos().saturating_sub(self.local_at(time).as_nanos());
            match u64::try_from(left) {
                Ok(left) if left > 0 => time = time.saturating_add(left),
                _ => return Some(time),
            }
            if time > u64::MAX / 4 {
                return None;
            }
        }
    }
}

impl Outside for Side {
    fn physical_time(&self) -> Instant {
        self.physical_at(self.now())
    }

    fn wake(&self) {
        self.woken.store(true, Ordering::Relaxed);
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }
}
