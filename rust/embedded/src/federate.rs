// SPDX-License-Identifier: Apache-2.0
//! The program of an image: its static memory, and how to run it.

use lf_model::time::Tag;
use lf_model::{Engine, EngineStorage, Program};
use lf_runtime::platform::Platform;
use lf_runtime::trace::Recording;
use lf_runtime::{
    Coordination, Description, FederateLoop, ImageError, Inbound, Join, Outbound, PEERS, SettingsError, TRANSIENTS,
    UnfederatedLoop,
};

pub use lf_runtime::{Federation, Needs};

use crate::cell::{Once, StaticSlot};

/// Runs a program of generated code, given by its module and type, in static memory: on this platform, with a function
/// that returns which federation to join (see [`Memory::run`]), and buffers of at least these sizes ([`MinBuffers`]).
///
/// The module also contains `DESCRIPTION` and `Storage`. The outcome is that of [`Memory::run`].
#[macro_export]
macro_rules! run {
    ($module:ident::$program:ident, $platform:expr, $recording:expr, $join:expr, $minimum:expr) => {{
        const SIZES: $crate::federate::Sizes = $crate::federate::Sizes::of(&$module::DESCRIPTION, $minimum);
        static MEMORY: $crate::federate::Memory<$module::$program, $module::Storage, $crate::buffers_of!(SIZES)> =
            $crate::federate::Memory::new();
        const PART: &$crate::federate::Federation = $module::DESCRIPTION.part();
        #[derive(Clone, Copy, Debug)]
        struct Needs;
        impl $crate::federate::Needs for Needs {
            const CENTRALIZED: bool = PART.is_centralized();
            const DECENTRALIZED: bool = !PART.is_centralized();
            const INPUTS: bool = PART.has_inputs();
            const CYCLES: bool = PART.is_centralized() && PART.cycles || PART.has_inputs();
            const AUTHENTICATION: bool = PART.authentication.is_some();
            const AWAITED: bool = !PART.awaited.is_empty();
            const PEERS_IN: bool = !PART.peers_in.is_empty();
            const PEERS_OUT: bool = !PART.peers_out.is_empty();
            const UNTAGGED: bool = PART.untagged;
            const TRANSIENTS: bool = !PART.transients.is_empty();
            const PHYSICAL: bool = PART.is_centralized() && PART.physical_delay.is_some();
            const CLOCK_SYNC: bool = PART.clock_sync.trials() > 0;
            const BUFFER_CHECK: bool = false;
            const WINDOW: bool = false;
            const WAITS: bool = PART.log_waits.is_some();
        }
        MEMORY.run::<Needs>($platform, $recording, &$module::DESCRIPTION, $join, $module::$program::new)
    }};
}

/// Names the type of [`Buffers`](federate::Buffers) with these [`Sizes`](federate::Sizes), which are a `const`.
#[macro_export]
macro_rules! buffers_of {
    ($sizes:ident) => {
        $crate::federate::Buffers<
            { $sizes.input_bytes },
            { $sizes.output_bytes },
            { $sizes.awaited },
            { $sizes.peers_in },
            { $sizes.peer_input_bytes },
            { $sizes.peers_out },
            { $sizes.peer_output_bytes },
        >
    };
}

/// The static memory of a program `P` with its engine's storage `S` and its connections' buffers `B`.
///
/// It is a static and not on a thread's stack, so that the linker counts it.
pub struct Memory<P, S, B>(Once<FederateParts<P, S, B>>);

struct FederateParts<P, S, B> {
    program: StaticSlot<P>,
    storage: StaticSlot<S>,
    buffers: B,
    /// Its size is the same on each platform and with each [`Needs`].
    federate: StaticSlot<Option<FederateLoop<'static, 'static, ()>>>,
}

impl<P: Program, S: EngineStorage, B: BufferStorage> Memory<P, S, B> {
    /// Returns memory before its first use.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        Self(Once::new(FederateParts {
            program: StaticSlot::EMPTY,
            storage: StaticSlot::EMPTY,
            buffers: B::EMPTY,
            federate: StaticSlot::EMPTY,
        }))
    }

    /// Runs the program in this memory, from its start to its end.
    ///
    /// It tells `recording` what happens. What the program does not need by `N` is not linked. A federate joins the
    /// federation that `join` says, or that of its description if that names none.
    ///
    /// # Errors
    /// The reason why it ended early.
    pub fn run<N: Needs>(
        &'static self,
        platform: &mut impl Platform,
        recording: Recording<'_>,
        description: &'static Description,
        join: impl FnOnce() -> Result<Join<'static>, SettingsError>,
        program: impl FnOnce() -> P,
    ) -> Result<(), ImageError> {
        let parts = self.0.take().ok_or(ImageError::Running)?;
        let (program, storage) = (parts.program.fill(program), parts.storage.fill(S::new));
        let (tables, settings) = (program.tables(), description.settings());
        let Some(federation) = &description.federation else {
            let mut alone = UnfederatedLoop::new(platform, program, Engine::new(tables, storage, settings));
            alone.record(recording);
            return alone.run().map_err(ImageError::Run);
        };
        let Join { federation_id, rti, others } = join().map_err(ImageError::Settings)?;
        let own_id = federation.federation_id.as_bytes();
        let join = Join { federation_id: if federation_id.is_empty() { own_id } else { federation_id }, rti, others };
        description.check_key(join.federation_id);
        let room = &mut parts.federate;
        // The federate is large and is constructed in place, and so is the engine.
        let ended = parts.buffers.with(|buffers, known| {
            let (engine, place) = (Engine::new(tables, storage, settings), room.room().write(None));
            let federate: Result<&mut FederateLoop<'_, '_, _, N>, _> =
                FederateLoop::new_in(place, platform, program, engine, federation, &join, buffers, known);
            let ended = federate.and_then(|federate| {
                federate.record(recording);
                federate.run()
            });
            *place = None;
            ended
        });
        ended.map_err(ImageError::Run)
    }
}

/// The memory of a federate's connections, without the sizes in its type.
pub trait BufferStorage: Send + 'static {
    /// Fresh memory, all zero.
    const EMPTY: Self;

    /// Calls a function with the buffers, and a tag for each awaited input.
    fn with<T>(&'static mut self, run: impl for<'s> FnOnce(lf_runtime::Buffers<'s>, &'s mut [Tag]) -> T) -> T;
}

/// The memory of a federate's connections, with its [`Sizes`]: [`buffers_of!`](crate::buffers_of) names the type.
pub struct Buffers<
    const INPUT: usize,
    const OUTPUT: usize,
    const AWAITED: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> {
    input: [u8; INPUT],
    output: [u8; OUTPUT],
    known: [StaticSlot<Tag>; AWAITED],
    peer_inputs: [[u8; IN_BYTES]; INS],
    peer_outputs: [[u8; OUT_BYTES]; OUTS],
}

impl<
    const INPUT: usize,
    const OUTPUT: usize,
    const AWAITED: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> BufferStorage for Buffers<INPUT, OUTPUT, AWAITED, INS, IN_BYTES, OUTS, OUT_BYTES>
{
    const EMPTY: Self = Self {
        input: [0; INPUT],
        output: [0; OUTPUT],
        known: [StaticSlot::EMPTY; AWAITED],
        peer_inputs: [[0; IN_BYTES]; INS],
        peer_outputs: [[0; OUT_BYTES]; OUTS],
    };

    fn with<T>(&'static mut self, run: impl for<'s> FnOnce(lf_runtime::Buffers<'s>, &'s mut [Tag]) -> T) -> T {
        let Self { input, output, known, peer_inputs, peer_outputs } = self;
        let known = StaticSlot::fill_all(known, core::iter::repeat(Tag::NEVER));
        let mut inbound = peer_inputs.each_mut().map(|bytes| Inbound::new(bytes));
        let mut outbound = peer_outputs.each_mut().map(|bytes| Outbound::new(bytes));
        run(lf_runtime::Buffers::new(input, output).with_peers(&mut outbound, &mut inbound), known)
    }
}

/// The minimum buffer sizes that a system asks for. The buffers are larger if the program needs it.
#[derive(Clone, Copy, Debug)]
pub struct MinBuffers {
    /// Bytes of the buffer for messages from the RTI.
    pub input_bytes: usize,
    /// Bytes of the buffer for messages to the RTI.
    pub output_bytes: usize,
}

/// The sizes of a program's connections. One that is not federated has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Bytes of the buffer for messages from the RTI.
    pub input_bytes: usize,
    /// Bytes of the buffer for messages to the RTI.
    pub output_bytes: usize,
    /// The number of awaited inputs.
    pub awaited: usize,
    /// The number of federates that send to this one directly.
    pub peers_in: usize,
    /// Bytes of the buffer for messages from each of them.
    pub peer_input_bytes: usize,
    /// The number of federates to which this one sends directly.
    pub peers_out: usize,
    /// Bytes of the buffer for messages to each of them.
    pub peer_output_bytes: usize,
}

impl Sizes {
    /// Returns the sizes that a program needs, and at least those that its system asks for.
    ///
    /// # Panics
    /// When the program has direct connections, and this crate lacks the feature `peers`, or transient federates
    /// without the feature `transients`. In a constant, this is an error of the compiler.
    pub const fn of(description: &Description, minimum: MinBuffers) -> Self {
        let Some(federation) = &description.federation else {
            return Self {
                input_bytes: 0,
                output_bytes: 0,
                awaited: 0,
                peers_in: 0,
                peer_input_bytes: 0,
                peers_out: 0,
                peer_output_bytes: 0,
            };
        };
        let is_centralized = matches!(federation.coordination, Coordination::Centralized);
        let needs_peers = !is_centralized || !federation.peers_in.is_empty() || !federation.peers_out.is_empty();
        assert!(PEERS || !needs_peers, "the program needs the feature `peers` of its system's crate");
        let has_transients = !federation.transients.is_empty();
        assert!(TRANSIENTS || !has_transients, "the program needs the feature `transients` of its system's crate");
        Self {
            input_bytes: larger(federation.input_bytes, minimum.input_bytes),
            output_bytes: larger(federation.output_bytes, minimum.output_bytes),
            awaited: federation.awaited.len(),
            peers_in: federation.peers_in.len(),
            peer_input_bytes: federation.peer_input_bytes,
            peers_out: federation.peers_out.len(),
            peer_output_bytes: federation.peer_output_bytes,
        }
    }
}

pub(crate) const fn larger(one: usize, other: usize) -> usize {
    if one > other { one } else { other }
}
