// SPDX-License-Identifier: Apache-2.0
//! The deterministic simulator: whole federations in virtual time.
//!
//! A seed stands for a random federation as LF source text, and for a world: clocks that differ and drift, a network
//! with delays and pieces and small buffers, programs that vanish. The compiler makes a plan of the text, as for any
//! program; here the plan is interpreted instead of emitted, with the model's own engine, ports and queues, and with
//! reactions that do what a hash says. The real event loops of federates and RTI run it, all in one thread.
//!
//! What must hold is checked from outside: see `check`. The reference for what a program does is the same text with
//! `main` for `federated`, run by the same engine; what chance decided (when physical actions happened, and which stop
//! was granted) is taken over from the federated run.
//!
//! The tables that both runs interpret are the compiler's own derivation ([`lf_compiler::tables`]), the same that
//! generated code is printed from: so they are not a reference for each other. The oracle is the run alone. It has no
//! federates, so none of what the derivation says of the network (inputs, outputs, levels across federates, readers,
//! what can be tardy) takes part in it, and a mistake there shows as another trace. What the text means otherwise,
//! `check` takes from the scenario and from the bytes on the wire.
//!
//! One seed is one run, bit for bit. A run that violates something is made smaller, and printed with the command that
//! repeats it.
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

/// Runs the scenarios of these seeds, and gives the hash of each run, or what was violated.
///
/// # Errors
/// What the first run violated, with the command that repeats it.
pub fn try_seeds(coordination: Coordination, seeds: std::ops::Range<u64>) -> Result<Vec<u64>, String> {
    let try_seed = |seed| {
        let (_, trial) = trial::try_seed(coordination, seed);
        match trial.violation {
            None => Ok(trial.digest),
            Some(violation) => {
                let option = workers::option(coordination);
                Err(format!("seed {seed}: {violation}\nrepeat with: cargo xtask simulate{option} --seed {seed}"))
            }
        }
    };
    with_stack(|| seeds.map(try_seed).collect())
}

/// Runs something with a stack on which the largest queues can be made, also without optimization.
fn with_stack<R: Send>(run: impl FnOnce() -> R + Send) -> R {
    const STACK_BYTES: usize = 64 << 20;
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run);
        let thread = thread.expect("the system has room for a thread");
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
