// SPDX-License-Identifier: Apache-2.0
//! Participants in virtual time: each on a thread of its own, of which one runs at a time.
//!
//! Whoever waits hands the turn on to one of those that have a reason to run; the seed says to which. Virtual time
//! stands still meanwhile, and moves on only when nobody has a reason, to the earliest time that anybody waits for. So
//! a run follows from its seed alone, and takes no longer than its work.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};

use lf_coordination::Deadline;
use lf_coordination::clock_sync::ClockCorrection;
use lf_model::time::{Instant, Interval};
use lf_model::{Mailbox, Outside};
use lf_runtime::platform::{Endpoint, Interest, IpAddress, NetError, Platform, RandomError, SocketId, Transfer};
use lf_runtime::trace::{Event, Record, Recorder};
use lf_testkit::network::Network;
use lf_testkit::random::Random;

use super::network::{Conditions, Move, Wires};

/// Where every participant's clock stands at the beginning, before its own offset.
const EPOCH_NS: i64 = 1_000_000_000_000;

/// What goes wrong with a world as a whole, which then interrupts everybody.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Trouble {
    /// All wait for something that will never come.
    Stuck,
    /// They have run far more often than they can have had reason to.
    Busy,
}

/// Something that happens to a participant from outside.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Fate {
    /// Somebody asks it to end (^C).
    Interrupt,
    /// It is no more: its system closes its sockets.
    Kill,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Status {
    /// It waits until this time, or for its sockets.
    Waiting(Option<u64>),
    /// It computes until this time, and sees nothing meanwhile.
    Computing(u64),
    Running,
    Done,
}

#[derive(Debug)]
struct Participant {
    status: Status,
    woken: bool,
    interrupted: bool,
    clock_offset: i64,
}

struct State {
    now: u64,
    random: Random,
    network: Network<Wires>,
    participants: Vec<Participant>,
    /// What each has recorded.
    records: Vec<Vec<Record>>,
    turn: Option<usize>,
    fates: Vec<(u64, usize, Fate)>,
    turns_left: u64,
    trouble: Option<Trouble>,
    /// It did not even end after it was interrupted.
    hopeless: bool,
}

/// A world before or while it runs.
#[derive(Clone)]
pub struct World(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    turn: Condvar,
}

impl World {
    pub fn new(conditions: Conditions) -> Self {
        let state = State {
            now: 0,
            random: Random::new(conditions.seed),
            network: Network::new(Wires::new(conditions)),
            participants: Vec::new(),
            records: Vec::new(),
            turn: None,
            fates: Vec::new(),
            turns_left: 60_000,
            trouble: None,
            hopeless: false,
        };
        Self(Arc::new(Shared { state: Mutex::new(state), turn: Condvar::new() }))
    }

    /// A participant that begins at this virtual time, with a clock that is ahead of the others by `clock_offset`.
    pub fn join(&self, begins: Interval, clock_offset: Interval) -> VirtualPlatform {
        let mut state = self.state();
        let begins = u64::try_from(begins.as_nanos()).expect("not before the world");
        let clock_offset = clock_offset.as_nanos();
        let status = Status::Waiting(Some(begins));
        state.participants.push(Participant { status, woken: false, interrupted: false, clock_offset });
        state.records.push(Vec::new());
        let me = state.network.join();
        let side = Side {
            world: self.clone(),
            me,
            correction: Mutex::new(ClockCorrection::NONE),
            mailbox: Mailbox::new(),
            latest: AtomicI64::new(i64::MIN),
        };
        VirtualPlatform { world: self.clone(), me, side: Box::leak(Box::new(side)) }
    }

    /// Something happens to a participant at this virtual time.
    pub fn plan(&self, at: Interval, participant: usize, fate: Fate) {
        let at = u64::try_from(at.as_nanos()).expect("not before the world");
        self.state().fates.push((at, participant, fate));
    }

    /// Gives the first turn. Each participant's thread begins with [`VirtualPlatform::begin`].
    pub fn start(&self) {
        self.state().hand_over();
        self.0.turn.notify_all();
    }

    /// What went wrong, if something did.
    pub fn trouble(&self) -> Option<Trouble> {
        self.state().trouble
    }

    /// What those that accept connections have said and heard, in order.
    pub fn moves(&self) -> Vec<Move> {
        self.state().network.medium().moves().to_vec()
    }

    /// What each participant has recorded, in the order in which they have joined.
    pub fn records(&self) -> Vec<Vec<Record>> {
        self.state().records.clone()
    }

    /// Virtual time since the beginning.
    pub fn now(&self) -> Interval {
        Interval::from_nanos(i64::try_from(self.state().now).expect("less than centuries"))
    }

    /// A participant ends: its system closes its sockets, and it gets no further turn.
    pub fn leave(&self, participant: usize) {
        let mut state = self.state();
        let State { network, now, .. } = &mut *state;
        network.switch_off(participant, *now);
        state.participants[participant].status = Status::Done;
        state.hand_over();
        drop(state);
        self.0.turn.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Hands the turn on, and comes back with the next one.
    fn pause(&self, me: usize, status: Status) -> MutexGuard<'_, State> {
        let mut state = self.state();
        state.participants[me].status = status;
        state.hand_over();
        self.0.turn.notify_all();
        self.await_turn(me, state)
    }

    fn await_turn<'a>(&'a self, me: usize, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        let waiting = |state: &mut State| state.turn != Some(me) && !state.hopeless;
        let mut state = self.0.turn.wait_while(state, waiting).unwrap_or_else(std::sync::PoisonError::into_inner);
        assert!(!state.hopeless, "participant {me} does not end though it is interrupted: {:?}", state.trouble);
        state.participants[me].status = Status::Running;
        state
    }
}

impl State {
    /// Says whose turn is next.
    fn hand_over(&mut self) {
        self.turns_left = self.turns_left.saturating_sub(1);
        if self.turns_left == 0 {
            self.give_up(Trouble::Busy);
        }
        loop {
            self.apply_fates();
            let runnable: Vec<usize> = (0..self.participants.len()).filter(|index| self.may_run(*index)).collect();
            if !runnable.is_empty() {
                self.turn = Some(runnable[self.random.index(runnable.len())]);
                return;
            }
            if self.participants.iter().all(|participant| participant.status == Status::Done) {
                self.turn = None;
                return;
            }
            match self.next_time() {
                Some(time) => self.now = time,
                None if self.hopeless => return,
                None => self.give_up(Trouble::Stuck),
            }
        }
    }

    fn give_up(&mut self, trouble: Trouble) {
        self.hopeless = self.trouble.is_some();
        self.trouble.get_or_insert(trouble);
        self.turns_left = 20_000;
        for participant in &mut self.participants {
            (participant.interrupted, participant.woken) = (true, true);
        }
    }

    fn apply_fates(&mut self) {
        let now = self.now;
        for (_, index, fate) in self.fates.extract_if(.., |(at, ..)| *at <= now) {
            (self.participants[index].interrupted, self.participants[index].woken) = (true, true);
            if fate == Fate::Kill {
                self.network.switch_off(index, now);
            }
        }
    }

    fn may_run(&mut self, index: usize) -> bool {
        let participant = &self.participants[index];
        match participant.status {
            Status::Waiting(until) => {
                participant.woken
                    || until.is_some_and(|until| until <= self.now)
                    || self.network.next_ready(index).is_some_and(|at| at <= self.now)
            }
            Status::Computing(until) => until <= self.now,
            Status::Running | Status::Done => false,
        }
    }

    fn next_time(&self) -> Option<u64> {
        let waits = self.participants.iter().enumerate().flat_map(|(index, participant)| match participant.status {
            Status::Waiting(until) => [until, self.network.next_ready(index)],
            Status::Computing(until) => [Some(until), None],
            Status::Running | Status::Done => [None, None],
        });
        let fates = self.fates.iter().map(|(at, ..)| *at);
        waits.flatten().chain(fates).filter(|at| *at > self.now).min()
    }

    fn clock(&self, me: usize) -> i64 {
        EPOCH_NS + self.participants[me].clock_offset + i64::try_from(self.now).expect("less than centuries")
    }
}

/// What the threads of a virtual participant share with its event loop.
pub struct Side {
    world: World,
    me: usize,
    correction: Mutex<ClockCorrection>,
    mailbox: Mailbox,
    /// The latest time that was read, to see that time does not run backwards.
    latest: AtomicI64,
}

impl Side {
    /// Takes so much of virtual time, in which the event loop sees nothing.
    pub fn compute(&self, time: Interval) {
        let until = self.world.state().now + u64::try_from(time.as_nanos()).expect("computing takes time");
        drop(self.world.pause(self.me, Status::Computing(until)));
    }
}

impl Outside for Side {
    fn physical_time(&self) -> Instant {
        let local = Instant::from_nanos(self.world.state().clock(self.me));
        self.correction.lock().unwrap().physical(local)
    }

    fn wake(&self) {
        self.world.state().participants[self.me].woken = true;
    }

    fn mailbox(&self) -> &Mailbox {
        &self.mailbox
    }
}

/// A participant's platform. Dropping it ends the participant.
pub struct VirtualPlatform {
    world: World,
    me: usize,
    side: &'static Side,
}

impl VirtualPlatform {
    /// Waits for this participant's first turn.
    pub fn begin(&mut self) {
        let state = self.world.state();
        drop(self.world.await_turn(self.me, state));
    }

    /// The number of this participant.
    pub fn number(&self) -> usize {
        self.me
    }

    pub fn side(&self) -> &'static Side {
        self.side
    }

    /// What keeps the records of this participant.
    pub fn recorder(&self) -> WorldRecorder {
        WorldRecorder { world: self.world.clone(), me: self.me }
    }
}

/// Keeps what happens in a participant.
pub struct WorldRecorder {
    world: World,
    me: usize,
}

impl Recorder for WorldRecorder {
    fn record(&mut self, at: Instant, event: Event) {
        self.world.state().records[self.me].push(Record { at, event });
    }
}

impl Drop for VirtualPlatform {
    fn drop(&mut self) {
        self.world.leave(self.me);
    }
}

impl Platform for VirtualPlatform {
    fn now(&mut self) -> Instant {
        let now = self.world.state().clock(self.me);
        assert!(self.side.latest.swap(now, Ordering::Relaxed) <= now, "time runs backwards");
        Instant::from_nanos(now)
    }

    fn outside(&self) -> &'static dyn Outside {
        self.side
    }

    fn set_correction(&mut self, correction: ClockCorrection) {
        *self.side.correction.lock().unwrap() = correction;
    }

    fn random(&mut self, buffer: &mut [u8]) -> Result<(), RandomError> {
        let random = &mut self.world.state().random;
        buffer.fill_with(|| random.byte());
        Ok(())
    }

    fn connect(&mut self, address: Endpoint) -> Result<SocketId, NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.connect(self.me, address, *now)
    }

    fn connected(&mut self, socket: SocketId) -> Result<(), NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.connected(self.me, socket, *now)
    }

    fn listen(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.world.state().network.listen(self.me, port)
    }

    fn bind(&mut self, port: u16) -> Result<SocketId, NetError> {
        self.world.state().network.bind(self.me, port)
    }

    fn receive_from(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Option<(usize, Endpoint)>, NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.receive_from(self.me, socket, buffer, *now)
    }

    fn send_to(&mut self, socket: SocketId, to: Endpoint, bytes: &[u8]) -> Result<(), NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.send_to(self.me, socket, to, bytes, *now)
    }

    fn local_port(&mut self, listener: SocketId) -> Result<u16, NetError> {
        self.world.state().network.local_port(self.me, listener)
    }

    fn accept(&mut self, listener: SocketId) -> Result<Option<(SocketId, IpAddress)>, NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.accept(self.me, listener, *now)
    }

    fn read(&mut self, socket: SocketId, buffer: &mut [u8]) -> Result<Transfer, NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.read(self.me, socket, buffer, *now)
    }

    fn write(&mut self, socket: SocketId, bytes: &[u8]) -> Result<Transfer, NetError> {
        let State { network, now, .. } = &mut *self.world.state();
        network.write(self.me, socket, bytes, *now)
    }

    fn shut_down_writing(&mut self, socket: SocketId) {
        let State { network, now, .. } = &mut *self.world.state();
        network.shut_down_writing(self.me, socket, *now);
    }

    fn close(&mut self, socket: SocketId) {
        let State { network, now, .. } = &mut *self.world.state();
        network.close(self.me, socket, *now);
    }

    fn set_interest(&mut self, socket: SocketId, interest: Interest) {
        self.world.state().network.set_interest(self.me, socket, interest);
    }

    fn wait(&mut self, until: Deadline, ready: &mut dyn FnMut(SocketId, Interest)) {
        let until = match until {
            Deadline::Now => Some(0),
            Deadline::At(time) => {
                let ahead = time.as_nanos().saturating_sub(self.now().as_nanos());
                Some(self.world.state().now.saturating_add(u64::try_from(ahead).unwrap_or(0)))
            }
            Deadline::Never => None,
        };
        let mut state = self.world.pause(self.me, Status::Waiting(until));
        state.participants[self.me].woken = false;
        let mut sockets = Vec::new();
        state.network.ready(self.me, state.now, |socket, interest| sockets.push((socket, interest)));
        // A wait may leave some for the next one.
        while sockets.len() > 1 && state.random.percent(25) {
            let left = state.random.index(sockets.len());
            sockets.swap_remove(left);
        }
        drop(state);
        for (socket, interest) in sockets {
            ready(socket, interest);
        }
    }

    fn interrupted(&mut self) -> bool {
        self.world.state().participants[self.me].interrupted
    }
}
