// SPDX-License-Identifier: Apache-2.0
//! Event loops of federates, in the profile of a computer and in those of shipped images.

use lf_coordination::federate::Needs;
use lf_model::time::Tag;
use lf_model::{Engine, Program};
use lf_runtime::trace::{Recorder, Recording};
use lf_runtime::{All, Buffers, FederateLoop, Federation, Join, RunError};
use lf_testkit::profiles::{
    Centralized, CentralizedSource, CentralizedTransients, Decentralized, DecentralizedSource, DecentralizedTransients,
};

use super::federation::Plan;
use super::keys::Host;

/// The parts of a federate's event loop.
pub(crate) struct Parts<'a, 's> {
    pub program: &'a mut dyn Program,
    pub engine: Engine<'s>,
    pub federation: &'a Federation,
    pub join: &'a Join<'a>,
    pub buffers: Buffers<'s>,
    pub known: &'s mut [Tag],
    /// The recorder, if events are recorded, and whether with values.
    pub recorder: Option<(&'a mut dyn Recorder, bool)>,
}

/// The result of a federate, and the numbers of its late messages and of its lost ones.
pub(crate) type LoopResult = (Result<(), RunError>, u64, u64);

/// Runs the event loop of a federate with these needs to its end.
fn run_with<N: Needs>(platform: &mut Host<'_>, parts: Parts<'_, '_>) -> LoopResult {
    let Parts { program, engine, federation, join, buffers, known, recorder } = parts;
    match FederateLoop::<_, N>::new(platform, program, engine, federation, join, buffers, known) {
        Ok(mut federate) => {
            if let Some((recorder, values)) = recorder {
                federate.record(Recording::new(recorder, values));
            }
            (federate.run(), federate.late_messages(), federate.lost_messages())
        }
        Err(error) => (Err(error), 0, 0),
    }
}

/// Runs the event loop of a computer's federate, or of one `in_image` with the least profile that has what it needs.
pub(crate) fn run_loop(plan: &Plan, in_image: bool, platform: &mut Host<'_>, parts: Parts<'_, '_>) -> LoopResult {
    let federation = parts.federation;
    let is_plain = federation.authentication.is_none() && federation.log_waits.is_none();
    let is_source = plan.edges.iter().all(|edge| edge.to != federation.id) && is_plain;
    let is_physical = federation.physical_delay.is_some();
    let run = match (federation.is_centralized(), federation.transients) {
        _ if !in_image => run_with::<All>,
        // No profile has connections of both kinds.
        (true, _) if federation.untagged => run_with::<All>,
        (true, []) if is_source && !is_physical && !plan.has_cycle() => run_with::<CentralizedSource>,
        (true, []) => run_with::<Centralized>,
        (true, _) => run_with::<CentralizedTransients>,
        (false, []) if is_source => run_with::<DecentralizedSource>,
        (false, []) => run_with::<Decentralized>,
        (false, _) => run_with::<DecentralizedTransients>,
    };
    run(platform, parts)
}
