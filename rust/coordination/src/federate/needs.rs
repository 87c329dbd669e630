// SPDX-License-Identifier: Apache-2.0
//! What a program needs of a federate, known while it is compiled: what it does not need is not in its image.

use core::fmt::Debug;

/// What a program needs. A type stands for it, so that code that nobody needs is not even generated; on a computer,
/// where programs of any kind are run by the same code, that is [`All`].
pub trait Needs: Copy + Debug + 'static {
    /// Other federates send to it.
    const INPUTS: bool = true;
    /// The RTI may grant tags provisionally: where federates are in a cycle without delay, and to take back at a stop
    /// what it has granted to a federate with inputs.
    const CYCLES: bool = true;
    /// The federate and the RTI prove to each other that they know the federation's id.
    const AUTHENTICATION: bool = true;
    /// It sends to other federates past the RTI, or receives from them.
    const PEERS: bool = true;
    /// Physical actions can cause outputs to other federates.
    const PHYSICAL: bool = true;
    /// Its buffers may be too small, so it looks at them when it starts. Those of an image are made to measure.
    const BUFFER_CHECK: bool = true;
    /// It is said what the running federate waits for.
    const WAITS: bool = true;
}

/// All that there is.
#[derive(Clone, Copy, Debug)]
pub struct All;

impl Needs for All {}
