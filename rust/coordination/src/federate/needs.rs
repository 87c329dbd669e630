// SPDX-License-Identifier: Apache-2.0
//! The capabilities that a program needs of a federate, known at compile time: an image carries no others.

use core::fmt::Debug;

/// The capabilities that a program needs. They are a type, so that the compiler generates no code for the others. A
/// computer, where the same code runs programs of any kind, uses [`All`].
pub trait Needs: Copy + Debug + 'static {
    /// Other federates send to it.
    const INPUTS: bool = true;
    /// The RTI may grant tags provisionally: to federates in a cycle without delay, and at a stop, to revoke what it
    /// has granted to a federate with inputs.
    const CYCLES: bool = true;
    /// The federate and the RTI prove to each other that they know the federation id.
    const AUTHENTICATION: bool = true;
    /// It sends to other federates directly, or receives from them.
    const PEERS: bool = true;
    /// Physical actions can cause outputs to other federates.
    const PHYSICAL: bool = true;
    /// Its buffers may be too small, so it checks them when it starts. Those of an image have the right size by
    /// construction.
    const BUFFER_CHECK: bool = true;
    /// The running federate logs what it waits for.
    const WAITS: bool = true;
}

/// All capabilities.
#[derive(Clone, Copy, Debug)]
pub struct All;

impl Needs for All {}
