// SPDX-License-Identifier: Apache-2.0
//! The network between the participants of one run, in virtual time: a seed decides how long bytes travel, in which
//! pieces they come, which datagrams are lost, how far clocks differ, and how quick the participants are.
//!
//! The participants are processes, which run one after the other: [`lf_linux::virtual_network`] is their side.

use std::io;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use lf_linux::model::time::Interval;
use lf_linux::virtual_network::{VARIABLE, participant, serve};
use lf_testkit::network::Medium;
use lf_testkit::random::{Random, combine};
use lf_testkit::world::{ComputerSpeed, LivenessViolation, Side, Threads, Virtual};
use tempfile::TempDir;

/// The latest beginning of a participant.
const BEGINS_NS_MAX: i64 = 50_000_000;
/// The greatest difference of a clock at the beginning, and its greatest drift.
const CLOCK_OFFSET_NS_MAX: i64 = 10_000_000;
const CLOCK_DRIFT_PPB_MAX: i64 = 20_000;
/// The longest duration of a turn of an event loop, and the longest delay of its wake-up.
const TURN_NS: (i64, i64) = (100, 50_000);
const WAKE_NS_MAX: i64 = 100_000;
/// The shortest and the longest delay of a link are these powers of two, in nanoseconds: 16 µs and 2 ms.
const DELAY_NS_LOG: (u64, u64) = (14, 21);
/// The percentage of transfers that take ten times as long.
const SLOW_PERCENT: u64 = 2;
/// The percentage of datagrams that are lost, and of the others that come twice.
const LOST_PERCENT: u64 = 5;
const DOUBLE_PERCENT: u64 = 2;
/// The capacity of one direction of a connection.
const CONNECTION_BYTES: usize = 1 << 16;

/// The network of one run.
pub(crate) struct VirtualNetwork {
    world: Threads<Links>,
    socket: PathBuf,
    /// The folder of the socket, which lasts as long.
    _folder: TempDir,
}

impl VirtualNetwork {
    /// The largest number of participants, for which there are addresses.
    pub(crate) const PARTICIPANTS_MAX: usize = 254;

    /// Begins with all participants, which take part as soon as the last one of them is there. Their clocks differ if
    /// they are synchronized.
    ///
    /// # Errors
    /// When the system has no local socket for it.
    pub(crate) fn begin(seed: u64, participants: usize, clocks_differ: bool) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("lfz").tempdir()?;
        let socket = folder.path().join("network");
        let listener = UnixListener::bind(&socket)?;
        let mut random = Random::new(seed);
        let world = Threads::of(Links::new(&mut random, participants), Random::new(random.number()), u64::MAX);
        let add = |_| {
            let [offset, drift] = [CLOCK_OFFSET_NS_MAX, CLOCK_DRIFT_PPB_MAX].map(|most| random.time(-most, most));
            let side = if clocks_differ { Side::keep(offset, drift) } else { Side::keep(0, 0) };
            let begins = Interval::from_nanos(random.time(0, BEGINS_NS_MAX));
            let computer = ComputerSpeed { turn_ns: TURN_NS, wake_ns: WAKE_NS_MAX };
            world.add(begins, side, computer)
        };
        let platforms: Vec<_> = (0..participants).map(add).collect();
        let begun = world.clone();
        thread::spawn(move || {
            // If one of them ends before, the others have nobody to wait for, and the run ends.
            let Ok(all) = gather(&listener, platforms) else { return };
            begun.start();
            for (stream, mut platform) in all {
                thread::spawn(move || {
                    platform.begin();
                    serve(&stream, &mut platform);
                });
            }
        });
        Ok(Self { world, socket, _folder: folder })
    }

    /// Returns the environment variable of the participant with this number.
    pub(crate) fn variable(&self, number: usize) -> (String, String) {
        (VARIABLE.to_owned(), format!("{number}:{}", self.socket.display()))
    }

    /// Returns why the participants were interrupted, if they were.
    pub(crate) fn violation(&self) -> Option<String> {
        let violation = self.world.violation()?;
        let after = Duration::from_nanos(self.world.now().as_nanos().unsigned_abs()).as_secs_f64();
        Some(match violation {
            LivenessViolation::Deadlock => {
                format!("after {after:.3} s of virtual time, all participants wait for what never comes")
            }
            LivenessViolation::Livelock => format!("after {after:.3} s of virtual time, the participants find no end"),
        })
    }
}

/// Waits until each participant has come, in any order.
fn gather(listener: &UnixListener, platforms: Vec<Virtual<Links>>) -> io::Result<Vec<(UnixStream, Virtual<Links>)>> {
    let mut streams: Vec<Option<UnixStream>> = platforms.iter().map(|_| None).collect();
    while streams.iter().any(Option::is_none) {
        let (stream, _) = listener.accept()?;
        let number = participant(&stream)?;
        if let Some(place) = streams.get_mut(usize::from(number)) {
            *place = Some(stream);
        }
    }
    Ok(streams.into_iter().flatten().zip(platforms).collect())
}

/// The links of the participants, one for each.
#[derive(Debug)]
struct Links {
    /// The shortest delay of each, in nanoseconds, and the largest addition.
    delays: Vec<(u64, u64)>,
    /// Whether reads and writes move a part of what they could.
    has_pieces: bool,
    random: Random,
}

impl Links {
    fn new(random: &mut Random, participants: usize) -> Self {
        let mut delay = |_| {
            let (least, most) = DELAY_NS_LOG;
            let delay = 1 << random.range(least, most);
            (delay, random.range(0, delay))
        };
        let delays = (0..participants).map(&mut delay).collect();
        Self { delays, has_pieces: random.percent(50), random: Random::new(combine(random.number(), 1)) }
    }
}

impl Medium for Links {
    fn latency_ns(&mut self, owner: usize, _bytes: usize) -> u64 {
        let (delay, addition) = self.delays.get(owner).copied().unwrap_or_default();
        let factor = if self.random.percent(SLOW_PERCENT) { 10 } else { 1 };
        factor * (delay + self.random.range(0, addition))
    }

    fn pipe_bytes(&self, _owner: usize) -> usize {
        CONNECTION_BYTES
    }

    fn piece(&mut self, most: usize) -> usize {
        if self.has_pieces && self.random.percent(50) { self.random.count(1, most) } else { most }
    }

    fn copies(&mut self) -> usize {
        if self.random.percent(LOST_PERCENT) { 0 } else { 1 + usize::from(self.random.percent(DOUBLE_PERCENT)) }
    }

    fn random(&mut self) -> &mut Random {
        &mut self.random
    }
}
