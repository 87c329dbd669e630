// SPDX-License-Identifier: Apache-2.0
//! All federates of a federation in one thread.

use std::collections::VecDeque;
use std::fmt;
use std::os::fd::OwnedFd;
use std::time::{Duration, Instant};

use rustix::event::{Timespec, epoll};

use crate::{Access, Graph, Load, Peer, Result};

/// The longest time without any progress.
const SILENCE_MAX: Duration = Duration::from_secs(20);

/// A federation that has started.
pub struct Swarm {
    peers: Vec<Peer>,
    load: Load,
    epoll: OwnedFd,
    events: Vec<epoll::Event>,
    /// The federates that have work, and whether each is in that list.
    touched: Vec<usize>,
    is_touched: Vec<bool>,
    /// The federates that wait for room to write.
    full: Vec<bool>,
    /// The round of the slowest federate.
    floor: u64,
    /// The number of federates in each round, from that one on.
    in_round: VecDeque<usize>,
    sources: Vec<usize>,
    /// The duration of connecting and of the start barrier.
    pub start: Duration,
}

impl fmt::Debug for Swarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Swarm").field("peers", &self.peers).field("floor", &self.floor).finish_non_exhaustive()
    }
}

/// The traffic through an RTI.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traffic {
    /// The duration of the run.
    pub time: Duration,
    /// The number of messages that arrived.
    pub messages: u64,
    /// The number of TAGs and PTAGs that arrived.
    pub grants: u64,
}

impl Traffic {
    /// Returns the messages per second.
    pub fn messages_per_second(&self) -> f64 {
        rate(self.messages, self.time)
    }

    /// Returns the grants per second.
    pub fn grants_per_second(&self) -> f64 {
        rate(self.grants, self.time)
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of what happens in minutes are far below 2^53")]
fn rate(count: u64, time: Duration) -> f64 {
    count as f64 / time.as_secs_f64().max(1e-9)
}

impl Swarm {
    /// Lets all federates join this RTI, and start.
    ///
    /// # Errors
    /// When the RTI does not answer as it should, or the system has no resources.
    pub fn join(rti: Access, graph: &Graph, load: Load) -> Result<Self> {
        let begin = Instant::now();
        let peers: Result<Vec<_>> = (0..graph.federates).map(|id| Peer::join(rti, id, graph, load)).collect();
        let mut peers = peers?;
        peers.iter_mut().try_for_each(Peer::send_clock)?;
        peers.iter_mut().try_for_each(Peer::await_start)?;
        let start = begin.elapsed();
        let epoll = epoll::create(epoll::CreateFlags::CLOEXEC)?;
        for (index, peer) in peers.iter().enumerate() {
            peer.stream().set_nonblocking(true)?;
            epoll::add(&epoll, peer.stream(), key(index), epoll::EventFlags::IN)?;
        }
        let count = peers.len();
        let sources = (0..count).filter(|index| peers[*index].is_source()).collect();
        Ok(Self {
            peers,
            load,
            epoll,
            events: Vec::with_capacity(512),
            touched: (0..count).collect(),
            is_touched: vec![true; count],
            full: vec![false; count],
            floor: 0,
            in_round: VecDeque::from([count]),
            sources,
            start,
        })
    }

    /// Lets the federates run for this time, or until all have completed this many rounds.
    ///
    /// # Errors
    /// When the RTI breaks the rules, or nothing happens any more.
    pub fn run(&mut self, time: Duration, rounds: u64) -> Result<Traffic> {
        let (begin, before) = (Instant::now(), self.counts());
        while begin.elapsed() < time && self.floor < rounds {
            self.turn()?;
        }
        let (time, after) = (begin.elapsed(), self.counts());
        Ok(Traffic { time, messages: after.0 - before.0, grants: after.1 - before.1 })
    }

    /// Asks all federates to stop, and waits until all have left. Returns the duration.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn stop(&mut self) -> Result<Duration> {
        let begin = Instant::now();
        self.peers[0].ask_to_stop()?;
        self.touch(0);
        while !self.peers.iter().all(|peer| peer.ended) {
            self.turn()?;
        }
        Ok(begin.elapsed())
    }

    fn counts(&self) -> (u64, u64) {
        (self.peers.iter().map(|peer| peer.received).sum(), self.peers.iter().map(|peer| peer.grants).sum())
    }

    fn touch(&mut self, index: usize) {
        if !std::mem::replace(&mut self.is_touched[index], true) {
            self.touched.push(index);
        }
    }

    fn turn(&mut self) -> Result<()> {
        let mut next = 0;
        while next < self.touched.len() {
            let index = self.touched[next];
            next += 1;
            // From here on others may list it again, and it then runs once more.
            self.is_touched[index] = false;
            let before = self.peers[index].round;
            self.peers[index].advance(self.floor + self.load.rounds_ahead)?;
            self.count_rounds(index, before);
        }
        for index in std::mem::take(&mut self.touched) {
            self.write(index)?;
        }
        self.wait()
    }

    fn count_rounds(&mut self, index: usize, before: u64) {
        let after = self.peers[index].round;
        if after == before {
            return;
        }
        let place = |round: u64| usize::try_from(round - self.floor).unwrap_or(usize::MAX);
        let (from, to) = (place(before), place(after));
        if self.in_round.len() <= to {
            self.in_round.resize(to + 1, 0);
        }
        self.in_round[from] -= 1;
        self.in_round[to] += 1;
        if self.in_round[0] > 0 {
            return;
        }
        while self.in_round.front() == Some(&0) {
            self.in_round.pop_front();
            self.floor += 1;
        }
        for source in 0..self.sources.len() {
            self.touch(self.sources[source]);
        }
    }

    fn write(&mut self, index: usize) -> Result<()> {
        let peer = &mut self.peers[index];
        if peer.ended {
            return Ok(());
        }
        peer.write()?;
        let full = peer.has_output();
        if std::mem::replace(&mut self.full[index], full) != full {
            let room = if full { epoll::EventFlags::OUT } else { epoll::EventFlags::empty() };
            epoll::modify(&self.epoll, peer.stream(), key(index), epoll::EventFlags::IN | room)?;
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<()> {
        let time_out = if self.touched.is_empty() { SILENCE_MAX } else { Duration::ZERO };
        self.events.clear();
        let spare = rustix::buffer::spare_capacity(&mut self.events);
        let count = epoll::wait(&self.epoll, spare, Some(&Timespec::try_from(time_out)?))?;
        if count == 0 && self.touched.is_empty() {
            return Err(format!("nothing happens any more; the slowest federate is in round {}", self.floor).into());
        }
        for event in 0..self.events.len() {
            let data = self.events[event].data;
            let index = usize::try_from(data.u64())?;
            self.peers[index].read()?;
            if self.peers[index].ended {
                epoll::delete(&self.epoll, self.peers[index].stream())?;
                self.peers[index].stream().shutdown(std::net::Shutdown::Both).ok();
            }
            self.touch(index);
        }
        Ok(())
    }
}

fn key(index: usize) -> epoll::EventData {
    epoll::EventData::new_u64(index as u64)
}
