// SPDX-License-Identifier: Apache-2.0
//! The deterministic simulator: whole federations in virtual time.
//!
//! A seed stands for a random federation as LF source text, and for a world: clocks that differ and drift, a network
//! with delays and pieces and small buffers, programs that vanish. The compiler makes a plan of the text, as for any
//! program; the simulator interprets the plan instead of emitting code, with the model's own engine, ports and queues,
//! and with reactions whose effects follow from a hash. The real event loops of federates and RTI run it, all in one
//! thread.
//!
//! The checks look from outside: see `check`. The reference of a program's behavior is the same text with `main` for
//! `federated`, run by the same engine; the decisions of chance (the times of physical actions, and the granted stop)
//! are taken from the federated run.
//!
//! Both runs interpret tables of the compiler's own derivation ([`lf_compiler::tables`]), from which generated code is
//! printed too: so they are not a reference for each other. The oracle is the run alone. It has no federates, so the
//! network part of the derivation (inputs, outputs, levels across federates, readers, inputs that can be tardy) does
//! not affect it, and a mistake there shows as another trace. `check` takes all else about the program from the
//! scenario and from the bytes on the wire.
//!
//! Federates may come and go: see `scenario::transients`, and `docs/decisions/041-lives-are-instances.md`.
//!
//! One seed is one run, bit for bit. If a run violates an invariant, the simulator shrinks it, and prints it with the
//! command that repeats it.
#![forbid(unsafe_code)]

mod check;
mod command;
mod compile;
mod coverage;
mod program;
mod run;
mod scenario;
mod shrink;
mod trial;
mod waits;
mod workers;
mod world;

pub use command::main;
pub use lf_runtime::Coordination;
pub use scenario::RICH;

/// The kind of federation that a seed stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Kind {
    /// Its coordination.
    pub coordination: Coordination,
    /// Whether federates come and go while it runs.
    pub comings: bool,
}

impl From<Coordination> for Kind {
    fn from(coordination: Coordination) -> Self {
        Self { coordination, comings: false }
    }
}

/// Runs the scenarios of these seeds, and returns the hash of each run.
///
/// # Errors
/// Returns the violation of the first failed run, with the command that repeats it.
pub fn try_seeds(kind: Kind, seeds: std::ops::Range<u64>) -> Result<Vec<u64>, String> {
    let try_seed = |seed| {
        let (_, trial) = trial::try_seed(kind, seed);
        match trial.violation {
            None => Ok(trial.digest),
            Some(violation) => {
                let option = workers::options(kind);
                Err(format!("seed {seed}: {violation}\nrepeat with: cargo xtask simulate{option} --seed {seed}"))
            }
        }
    };
    with_stack(|| seeds.map(try_seed).collect())
}

/// Runs a closure with a stack that is large enough to construct the largest queues, even without optimization.
fn with_stack<R: Send>(run: impl FnOnce() -> R + Send) -> R {
    const STACK_BYTES: usize = 64 << 20;
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run);
        let thread = thread.expect("the system has room for a thread");
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
