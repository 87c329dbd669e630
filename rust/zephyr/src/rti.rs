// SPDX-License-Identifier: Apache-2.0
//! The RTI of an image: its static memory, and how it is run. Kconfig has its sizes, which the compiler works out.
//!
//! It runs in two steps, because a federate in the same image must find it listening: [`ImageRti::listen`], then
//! [`ImageRti::run`], which may be called from another thread.

use core::cell::UnsafeCell;
use core::fmt;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU8, Ordering};

use lf_coordination::clock_sync::RTI_UDP_PORT;
pub use lf_coordination::rti::ClockSync;
use lf_coordination::rti::{
    AfterLoss, Config, Connection, Node, Outcome, PathWords, RtiStorage, START_REPORT, Slot,
};
use lf_model::time::{Interval, Tag};
use lf_runtime::platform::{NetError, Platform, SocketId};
pub use lf_runtime::{AUTHENTICATOR, Authenticator};
use lf_runtime::{Inlet, Outgoing, RtiSetup, RunError, log_notice, run_rti};
use log::LevelFilter;

use crate::kconfig::{LF_RTI_BUFFER_SIZE, LF_RTI_CONNECTIONS, LF_RTI_FEDERATES, LF_RTI_IN_TRANSIT, LF_RTI_UPSTREAM};
use crate::platform::ZephyrPlatform;
use crate::settings::{self, SettingsError};

const _: () = assert!(LF_RTI_CONNECTIONS >= LF_RTI_FEDERATES, "each federate of the RTI needs one connection");

/// What an RTI knows of its federation.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// The federation id, unless Kconfig or the command line says another.
    pub federation_id: &'static str,
    /// How federates have to prove that they know the federation id, if they have to.
    pub authentication: Option<Authenticator>,
    /// Clock synchronization.
    pub clock_sync: ClockSync,
    /// Whether federates are told which of their next events nobody waits for.
    pub dnet: bool,
    /// After how long it is logged what a running federate waits for, if at all.
    pub log_waits: Option<Interval>,
    /// How much is logged.
    pub logging: LevelFilter,
    /// Bytes of the longest payload that is passed on.
    pub payload_bytes_max: usize,
}

impl Description {
    const fn config<'a>(&self, federation_id: &'a [u8]) -> Config<'a> {
        let mut config = Config::new(federation_id, self.payload_bytes_max);
        config.authentication = self.authentication;
        config.clock_sync = self.clock_sync;
        config.dnet = self.dnet;
        config.start_report = Some(START_REPORT);
        config.log_waits = self.log_waits;
        config.after_loss = AfterLoss::StopAll;
        config
    }
}

/// The longest of some lengths; 0 of none.
pub const fn longest(lengths: &[usize]) -> usize {
    let (mut longest, mut index) = (0, 0);
    while index < lengths.len() {
        if lengths[index] > longest {
            longest = lengths[index];
        }
        index += 1;
    }
    longest
}

/// Bytes of the buffer of each connection in each direction; Kconfig may ask for more.
pub const fn buffer_bytes(description: &Description) -> usize {
    longest(&[description.config(&[]).message_bytes_max(LF_RTI_FEDERATES), LF_RTI_BUFFER_SIZE])
}

/// The connections, the listener, and a port for datagrams.
const SOCKETS: usize = LF_RTI_CONNECTIONS + 1 + if cfg!(CONFIG_NET_UDP) { 1 } else { 0 };

type RtiPlatform = ZephyrPlatform<SOCKETS>;

/// Why the RTI of an image ends early.
#[derive(Debug)]
pub enum RtiError {
    /// A setting is of no use.
    Settings(SettingsError),
    /// The port cannot be listened on.
    Listen {
        /// The port.
        port: u16,
        /// Why not.
        error: NetError,
    },
    /// No UDP port can be opened for clock synchronization.
    Bind(NetError),
    /// The event loop ended early.
    Run(RunError),
    /// The federation did not end as it should.
    Ended(Outcome),
    /// A step was taken before the other, or a second time.
    Order,
}

impl fmt::Display for RtiError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settings(error) => error.fmt(f),
            Self::Listen { port, error } => {
                write!(f, "the RTI cannot listen on TCP port {port}: {error}; choose another one: CONFIG_LF_RTI_PORT")
            }
            Self::Bind(error) => write!(f, "the RTI cannot open a UDP port for clock synchronization: {error}"),
            Self::Run(error) => error.fmt(f),
            Self::Ended(outcome) => outcome.fmt(f),
            Self::Order => f.write_str("lf_rti_listen() and lf_rti_main() can be called only once, in this order"),
        }
    }
}

impl core::error::Error for RtiError {}

/// The RTI of an image, without the sizes in its type.
pub trait ImageRti: Sync {
    /// Lets federates connect; says on the console on which port.
    ///
    /// # Errors
    /// Why they cannot.
    fn listen(&'static self, description: &Description) -> Result<(), RtiError>;

    /// Runs the federation to its end.
    ///
    /// # Errors
    /// Why it ended early.
    fn run(&'static self, description: &Description) -> Result<(), RtiError>;
}

/// The static memory of an RTI with buffers of so many bytes. It is all zero at first, so it takes no flash.
pub struct Memory<const BYTES: usize> {
    stage: AtomicU8,
    parts: UnsafeCell<Parts<BYTES>>,
}

// The stages of its life. Whoever brings it from one to the next has the memory for itself meanwhile.
const FRESH: u8 = 0;
const OPENING: u8 = 1;
const LISTENING: u8 = 2;
const RUNNING: u8 = 3;

/// What is not written yet costs nothing in the image's file, and is never on a stack.
struct Parts<const BYTES: usize> {
    listening: MaybeUninit<Listening>,
    inputs: [[u8; BYTES]; LF_RTI_CONNECTIONS],
    outputs: [[u8; BYTES]; LF_RTI_CONNECTIONS],
    inlets: [MaybeUninit<Inlet<&'static mut [u8]>>; LF_RTI_CONNECTIONS],
    outgoings: [MaybeUninit<Outgoing<&'static mut [u8]>>; LF_RTI_CONNECTIONS],
    connections: [MaybeUninit<Connection>; LF_RTI_CONNECTIONS],
    slots: [MaybeUninit<Slot>; LF_RTI_FEDERATES],
    nodes: [MaybeUninit<Node>; LF_RTI_FEDERATES],
    paths: [PathWords; 2 * LF_RTI_FEDERATES * LF_RTI_FEDERATES],
    upstream: [PathWords; LF_RTI_FEDERATES * LF_RTI_UPSTREAM],
    in_transit: [MaybeUninit<Tag>; LF_RTI_FEDERATES * LF_RTI_IN_TRANSIT],
}

/// The RTI before it runs.
struct Listening {
    platform: RtiPlatform,
    listener: SocketId,
    datagrams: Option<SocketId>,
    federation_id: &'static [u8],
}

// SAFETY: the cell is accessed only by `listen` and `run`, each of which has it for itself: a stage is left only once,
// and what `listen` has written is there when `run` finds the stage that it has set.
unsafe impl<const BYTES: usize> Sync for Memory<BYTES> {}

impl<const BYTES: usize> fmt::Debug for Memory<BYTES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memory").field("stage", &self.stage).finish_non_exhaustive()
    }
}

impl<const BYTES: usize> Memory<BYTES> {
    /// Memory of an RTI that does not listen yet.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        let parts = Parts {
            listening: MaybeUninit::uninit(),
            inputs: [[0; BYTES]; LF_RTI_CONNECTIONS],
            outputs: [[0; BYTES]; LF_RTI_CONNECTIONS],
            inlets: [const { MaybeUninit::uninit() }; LF_RTI_CONNECTIONS],
            outgoings: [const { MaybeUninit::uninit() }; LF_RTI_CONNECTIONS],
            connections: [const { MaybeUninit::uninit() }; LF_RTI_CONNECTIONS],
            slots: [const { MaybeUninit::uninit() }; LF_RTI_FEDERATES],
            nodes: [const { MaybeUninit::uninit() }; LF_RTI_FEDERATES],
            paths: [[0; 2]; 2 * LF_RTI_FEDERATES * LF_RTI_FEDERATES],
            upstream: [[0; 2]; LF_RTI_FEDERATES * LF_RTI_UPSTREAM],
            in_transit: [const { MaybeUninit::uninit() }; LF_RTI_FEDERATES * LF_RTI_IN_TRANSIT],
        };
        Self { stage: AtomicU8::new(FRESH), parts: UnsafeCell::new(parts) }
    }

    fn go_on(&self, from: u8, to: u8) -> Result<(), RtiError> {
        let outcome = self.stage.compare_exchange(from, to, Ordering::AcqRel, Ordering::Relaxed);
        outcome.map(drop).map_err(|_| RtiError::Order)
    }
}

impl<const BYTES: usize> ImageRti for Memory<BYTES> {
    fn listen(&'static self, description: &Description) -> Result<(), RtiError> {
        self.go_on(FRESH, OPENING)?;
        // SAFETY: this call alone has found the stage to be `FRESH`, and nobody else accesses the cell meanwhile.
        let Parts { listening, .. } = unsafe { &mut *self.parts.get() };
        let federation_id = match settings::federation_id() {
            b"" => description.federation_id.as_bytes(),
            other => other,
        };
        let port = settings::own_rti_port().map_err(RtiError::Settings)?;
        let mut platform = RtiPlatform::without_wake();
        let failed = |error| RtiError::Listen { port, error };
        let listener = platform.listen(port).map_err(failed)?;
        let port = platform.local_port(listener).map_err(failed)?;
        let datagrams = match description.clock_sync {
            ClockSync::On { .. } => Some(open_datagrams(&mut platform).map_err(RtiError::Bind)?),
            ClockSync::Off | ClockSync::Init { .. } => None,
        };
        settings::set_own_rti_port(port);
        listening.write(Listening { platform, listener, datagrams, federation_id });
        self.go_on(OPENING, LISTENING)?;
        crate::println!("listening on TCP port {port}");
        Ok(())
    }

    fn run(&'static self, description: &Description) -> Result<(), RtiError> {
        self.go_on(LISTENING, RUNNING)?;
        // SAFETY: this call alone has found the stage to be `LISTENING`, and nobody else accesses the cell from now on.
        let parts: &'static mut Parts<BYTES> = unsafe { &mut *self.parts.get() };
        // SAFETY: it was written before the stage came to be `LISTENING`.
        let Listening { platform, listener, datagrams, federation_id } = unsafe { parts.listening.assume_init_mut() };
        let setup = RtiSetup {
            config: description.config(federation_id),
            storage: RtiStorage {
                slots: fill(&mut parts.slots, || Slot::EMPTY),
                nodes: fill(&mut parts.nodes, || Node::EMPTY),
                connections: fill(&mut parts.connections, || Connection::EMPTY),
                paths: &mut parts.paths,
                upstream: &mut parts.upstream,
                in_transit: fill(&mut parts.in_transit, || Tag::NEVER),
            },
            inlets: fill_from(&mut parts.inlets, slices(&mut parts.inputs).map(Inlet::new)),
            outgoings: fill_from(&mut parts.outgoings, slices(&mut parts.outputs).map(Outgoing::new)),
            datagrams: *datagrams,
        };
        match run_rti(platform, setup, *listener, &mut log_notice).map_err(RtiError::Run)? {
            Outcome::Complete => Ok(()),
            outcome => Err(RtiError::Ended(outcome)),
        }
    }
}

/// Buffers without their length in the type.
fn slices<const BYTES: usize>(buffers: &mut [[u8; BYTES]]) -> impl Iterator<Item = &mut [u8]> {
    buffers.iter_mut().map(|bytes| &mut bytes[..])
}

/// Opens a UDP port for clock synchronization. Federates answer to where the datagrams come from, so another port than
/// the usual one will do.
fn open_datagrams(platform: &mut RtiPlatform) -> Result<SocketId, NetError> {
    match platform.bind(RTI_UDP_PORT) {
        Err(NetError::AddressInUse) => platform.bind(0),
        outcome => outcome,
    }
}

fn fill<T>(places: &mut [MaybeUninit<T>], value: impl Fn() -> T) -> &mut [T] {
    fill_from(places, core::iter::repeat_with(value))
}

/// Writes values into as many places as there are values, and gives these places.
fn fill_from<T>(places: &mut [MaybeUninit<T>], values: impl Iterator<Item = T>) -> &mut [T] {
    let mut count = 0;
    for (place, value) in places.iter_mut().zip(values) {
        place.write(value);
        count += 1;
    }
    // SAFETY: the first so many places have just been written, and the slice borrows what `places` does.
    unsafe { core::slice::from_raw_parts_mut(places.as_mut_ptr().cast(), count) }
}
