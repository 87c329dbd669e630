// SPDX-License-Identifier: Apache-2.0
//! The program of an image: its static memory, and how it is run.

use core::cell::UnsafeCell;
use core::fmt;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use lf_model::time::Tag;
use lf_model::{Engine, Program, Settings, Storage, Tables};
use lf_runtime::{
    Buffers, Coordination, Description, Federation, Inbound, Join, Outbound, PEERS, RunError, run_federate,
    run_unfederated,
};

use crate::platform::ZephyrPlatform;
use crate::settings::{self, SettingsError};

/// Why the program of an image ends early.
#[derive(Debug)]
pub enum ImageError {
    /// Zephyr has no descriptor left for the wake-up.
    Platform(lf_runtime::platform::NetError),
    /// A setting is of no use.
    Settings(SettingsError),
    /// The event loop ended early.
    Run(RunError),
    /// The program was started before, and its memory is in use.
    Running,
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Platform(error) => {
                write!(f, "no descriptor for the wake-up ({error}): raise CONFIG_ZVFS_EVENTFD_MAX")
            }
            Self::Settings(error) => error.fmt(f),
            Self::Run(error) => error.fmt(f),
            Self::Running => f.write_str("lf_main() can be called only once"),
        }
    }
}

impl core::error::Error for ImageError {}

/// The memory of an engine, without the sizes in its type.
pub trait EngineStorage {
    /// Empty storage.
    fn empty() -> Self;

    /// An engine in this storage.
    fn engine(&mut self, tables: &'static Tables, settings: Settings) -> Engine<'_>;
}

impl<const T: usize, const TW: usize, const RW: usize, const PW: usize, const DW: usize, const D: usize> EngineStorage
    for Storage<T, TW, RW, PW, DW, D>
{
    fn empty() -> Self {
        Self::new()
    }

    fn engine(&mut self, tables: &'static Tables, settings: Settings) -> Engine<'_> {
        Engine::new(tables, self, settings)
    }
}

/// The static memory of a program `P` with its engine's storage `S`, buffers of so many bytes, so many tags for what is
/// known of inputs, and so many connections from and to other federates with buffers of so many bytes.
///
/// It is a static and not on the main thread's stack, so that the linker counts it.
pub struct Memory<
    P,
    S,
    const INPUT: usize,
    const OUTPUT: usize,
    const KNOWN: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> {
    taken: AtomicBool,
    parts: UnsafeCell<Parts<P, S, INPUT, OUTPUT, KNOWN, INS, IN_BYTES, OUTS, OUT_BYTES>>,
}

struct Parts<
    P,
    S,
    const INPUT: usize,
    const OUTPUT: usize,
    const KNOWN: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> {
    program: MaybeUninit<P>,
    storage: MaybeUninit<S>,
    input: [u8; INPUT],
    output: [u8; OUTPUT],
    known: MaybeUninit<[Tag; KNOWN]>,
    peer_inputs: [[u8; IN_BYTES]; INS],
    peer_outputs: [[u8; OUT_BYTES]; OUTS],
}

// SAFETY: the cell is accessed only by the one call of `run` that has set `taken`, which is never unset.
unsafe impl<
    P,
    S,
    const INPUT: usize,
    const OUTPUT: usize,
    const KNOWN: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> Sync for Memory<P, S, INPUT, OUTPUT, KNOWN, INS, IN_BYTES, OUTS, OUT_BYTES>
{
}

impl<
    P,
    S,
    const INPUT: usize,
    const OUTPUT: usize,
    const KNOWN: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> fmt::Debug for Memory<P, S, INPUT, OUTPUT, KNOWN, INS, IN_BYTES, OUTS, OUT_BYTES>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memory").field("taken", &self.taken).finish_non_exhaustive()
    }
}

impl<
    P: Program,
    S: EngineStorage,
    const INPUT: usize,
    const OUTPUT: usize,
    const KNOWN: usize,
    const INS: usize,
    const IN_BYTES: usize,
    const OUTS: usize,
    const OUT_BYTES: usize,
> Memory<P, S, INPUT, OUTPUT, KNOWN, INS, IN_BYTES, OUTS, OUT_BYTES>
{
    /// Memory that nothing is in yet.
    #[expect(clippy::new_without_default, reason = "it is for statics, which cannot use Default")]
    pub const fn new() -> Self {
        let parts = Parts {
            program: MaybeUninit::uninit(),
            storage: MaybeUninit::uninit(),
            input: [0; INPUT],
            output: [0; OUTPUT],
            known: MaybeUninit::uninit(),
            peer_inputs: [[0; IN_BYTES]; INS],
            peer_outputs: [[0; OUT_BYTES]; OUTS],
        };
        Self { taken: AtomicBool::new(false), parts: UnsafeCell::new(parts) }
    }

    /// Runs the program in this memory, from its start to its end.
    ///
    /// # Errors
    /// Why it ended early.
    pub fn run(
        &'static self,
        platform: &mut ZephyrPlatform,
        description: &'static Description,
        program: impl FnOnce() -> P,
    ) -> Result<(), ImageError> {
        if self.taken.swap(true, Ordering::Acquire) {
            return Err(ImageError::Running);
        }
        // SAFETY: this call alone has found `taken` unset, and nobody else accesses the cell.
        let parts = unsafe { &mut *self.parts.get() };
        let Parts { program: program_place, storage, input, output, known, peer_inputs, peer_outputs } = parts;
        let (program, storage) = (fill(program_place, program), fill(storage, S::empty));
        let known = fill(known, || [Tag::NEVER; KNOWN]);
        let engine = storage.engine(program.tables(), description.settings());
        let Some(federation) = &description.federation else {
            return run_unfederated(platform, program, engine).map_err(ImageError::Run);
        };
        let join = join(federation).map_err(ImageError::Settings)?;
        description.check_key(join.federation_id);
        let mut inbound = peer_inputs.each_mut().map(|bytes| Inbound::new(bytes));
        let mut outbound = peer_outputs.each_mut().map(|bytes| Outbound::new(bytes));
        let buffers = Buffers::new(input, output).with_peers(&mut outbound, &mut inbound);
        run_federate(platform, program, engine, federation, &join, buffers, known).map_err(ImageError::Run)
    }
}

/// Fills a place in the static memory. It is not inlined, so that what lies on the stack on the way there is gone from
/// it before the event loop begins.
#[inline(never)]
fn fill<T>(place: &mut MaybeUninit<T>, value: impl FnOnce() -> T) -> &mut T {
    place.write(value())
}

fn join(federation: &Federation) -> Result<Join<'static>, SettingsError> {
    let federation_id = match settings::federation_id() {
        b"" => federation.federation_id.as_bytes(),
        other => other,
    };
    Ok(Join { federation_id, rti: settings::rti_address()? })
}

/// Bytes of the receive buffer that a program needs; Kconfig may ask for more.
pub const fn input_bytes(description: &Description) -> usize {
    match &description.federation {
        Some(federation) => larger(federation.input_bytes, crate::kconfig::LF_RECEIVE_BUFFER_SIZE),
        None => 0,
    }
}

/// Bytes of the send buffer that a program needs; Kconfig may ask for more.
pub const fn output_bytes(description: &Description) -> usize {
    match &description.federation {
        Some(federation) => larger(federation.output_bytes, crate::kconfig::LF_SEND_BUFFER_SIZE),
        None => 0,
    }
}

/// How many inputs of a program are awaited.
pub const fn awaited_inputs(description: &Description) -> usize {
    match &description.federation {
        Some(federation) => federation.awaited.len(),
        None => 0,
    }
}

/// Whether the crate has what its program needs: the feature `peers` for connections with others, past the RTI.
pub const fn has_needed(description: &Description) -> bool {
    match &description.federation {
        Some(federation) => {
            let is_centralized = matches!(federation.coordination, Coordination::Centralized);
            PEERS || is_centralized && federation.peers_in.is_empty() && federation.peers_out.is_empty()
        }
        None => true,
    }
}

/// How many federates send to this one over physical connections, and bytes of the receive buffer of each.
pub const fn peers_in(description: &Description) -> (usize, usize) {
    match &description.federation {
        Some(federation) => (federation.peers_in.len(), federation.peer_input_bytes),
        None => (0, 0),
    }
}

/// To how many federates this one sends over physical connections, and bytes of the send buffer of each.
pub const fn peers_out(description: &Description) -> (usize, usize) {
    match &description.federation {
        Some(federation) => (federation.peers_out.len(), federation.peer_output_bytes),
        None => (0, 0),
    }
}

const fn larger(one: usize, other: usize) -> usize {
    if one > other { one } else { other }
}
