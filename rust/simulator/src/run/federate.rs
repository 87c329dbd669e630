// SPDX-License-Identifier: Apache-2.0
//! A federate with its memory, which generated code has in statics.

use lf_compiler::plan::{self, Plan};
use lf_model::time::{Interval, Tag};
use lf_model::{Engine, EngineStorage, Program as _, Settings, Storage, Tables};
use lf_runtime::platform::Endpoint;
use lf_runtime::trace::Recording;
use lf_runtime::{
    AwaitedInput, Buffers, ClockSync, Coordination, DELAY_NONE, FederateLoop, Federation, Inbound, Join, Outbound,
    RunError,
};
use lf_testkit::network::address_of;
use lf_testkit::random::combine;
use lf_testkit::trace::Records;

use super::rti::{FEDERATION_ID, PORT};
use crate::program::{BuildError, Runs, Scripted};
use crate::scenario::Scenario;
use crate::world::Virtual;

/// A federate's event loop.
pub(super) type Member<'a> = FederateLoop<'a, 'a, Virtual>;

/// The memory of an engine, in one of two sizes.
pub(super) enum EngineMemory {
    Small(Box<Storage<64, 2, 4, 4, 4, 8, 16, 64>>),
    Large(Box<Storage<2048, 64, 64, 64, 64, 8, 256, 2048>>),
}

impl EngineMemory {
    pub(super) fn new(tables: &Tables) -> Self {
        let modes = tables.mode_count();
        if modes <= 16 && tables.triggers.len() <= 64 && tables.reactions.len() <= 128 && tables.ports.len() <= 128 {
            Self::Small(Box::new(EngineStorage::new()))
        } else {
            Self::Large(Box::new(EngineStorage::new()))
        }
    }

    pub(super) fn engine(&mut self, tables: &'static Tables, settings: Settings) -> Engine<'_> {
        match self {
            Self::Small(storage) => Engine::new(tables, &mut **storage, settings),
            Self::Large(storage) => Engine::new(tables, &mut **storage, settings),
        }
    }
}

/// All memory of a federate.
pub(super) struct FederateMemory {
    pub(super) program: Scripted,
    /// The recorder, if the run is recorded.
    records: Option<Records>,
    platform: Virtual,
    engine: EngineMemory,
    settings: Settings,
    federation: Federation,
    input: Vec<u8>,
    output: Vec<u8>,
    /// The buffers of the connections to and from other federates.
    outbound: Vec<Vec<u8>>,
    inbound: Vec<Vec<u8>>,
    /// The tags up to which awaited inputs are known.
    known: Vec<Tag>,
}

impl FederateMemory {
    pub(super) fn new(
        scenario: &Scenario,
        plan: &Plan,
        instance: usize,
        platform: Virtual,
        records: Option<Records>,
    ) -> Result<Self, BuildError> {
        let federate = &plan.federates[scenario.instances[instance]];
        let mut program = Scripted::new(scenario, plan, federate, platform.side(), None, Runs::OneByOne)?;
        program.set_states(first_state(scenario, instance));
        let tables = program.tables();
        let target = &plan.target;
        let settings = Settings {
            federated: true,
            timeout: target.timeout_ns.map(Interval::from_nanos),
            // As for all programs in Rust, where the compiler knows all sources of events.
            keepalive: false,
            fast: target.fast,
        };
        let federation = federation(plan, federate, tables);
        let input_bytes = federation.input_bytes + scenario.conditions.receive_spare;
        let federation = Federation { window: federation.window_of(tables, input_bytes), ..federation };
        let peer_spare = scenario.decentralized.map_or(0, |it| it.peer_spare);
        Ok(Self {
            program,
            records,
            platform,
            engine: EngineMemory::new(tables),
            settings,
            input: vec![0; input_bytes],
            output: vec![0; federation.output_bytes + scenario.conditions.send_spare],
            outbound: vec![vec![0; federation.peer_output_bytes + peer_spare.min(4096)]; federation.peers_out.len()],
            inbound: vec![vec![0; federation.peer_input_bytes + peer_spare]; federation.peers_in.len()],
            known: vec![Tag::NEVER; federation.awaited.len()],
            federation,
        })
    }

    /// Starts the federate.
    pub(super) fn begin(&mut self) -> Result<Member<'_>, RunError> {
        let tables = self.program.tables();
        let engine = self.engine.engine(tables, self.settings);
        let join = Join { federation_id: FEDERATION_ID, rti: Endpoint::new(address_of(0), PORT), others: &[] };
        let outbound: Vec<_> = self.outbound.iter_mut().map(|bytes| Outbound::new(bytes)).collect();
        let inbound: Vec<_> = self.inbound.iter_mut().map(|bytes| Inbound::new(bytes)).collect();
        let buffers = Buffers::new(&mut self.input, &mut self.output).with_peers(outbound.leak(), inbound.leak());
        let mut federate = FederateLoop::new(
            &mut self.platform,
            &mut self.program,
            engine,
            &self.federation,
            &join,
            buffers,
            &mut self.known,
        )?;
        if let Some(records) = &mut self.records {
            federate.record(Recording::new(records, true));
        }
        Ok(federate)
    }
}

/// Returns the state of an instance of a federate before its first tag. It differs for each, and so do the values that
/// they send.
pub(super) fn first_state(scenario: &Scenario, instance: usize) -> u64 {
    if instance < scenario.federates.len() { scenario.seed } else { combine(scenario.seed, instance as u64) }
}

/// Returns the configuration of the federation, as generated code has it.
fn federation(plan: &Plan, federate: &plan::Federate, tables: &Tables) -> Federation {
    let planned = lf_compiler::tables::Tables::of(plan, federate);
    let upstream: Vec<_> =
        planned.upstream.iter().map(|(id, delay_ns)| (*id, delay_ns.unwrap_or(DELAY_NONE))).collect();
    let awaited: Vec<_> =
        planned.awaited.iter().map(|(port, level)| AwaitedInput { port: *port, level: *level }).collect();
    Federation {
        id: federate.id,
        federation_id: "simulated",
        coordination: if plan.is_decentralized() { Coordination::Decentralized } else { Coordination::Centralized },
        federates: u16::try_from(plan.federates.len()).unwrap_or(u16::MAX),
        rti_host: "10.0.0.1",
        rti_port: PORT,
        upstream: upstream.leak(),
        downstream: federate.downstream.clone().leak(),
        peers_in: federate.peers_in().leak(),
        peers_out: federate.peers_out().leak(),
        transients: plan.transient_neighbors(federate).leak(),
        awaited: awaited.leak(),
        clock_sync: match plan.target.clock_sync {
            plan::ClockSync::Off => ClockSync::Off,
            plan::ClockSync::Init => ClockSync::Init { trials: plan.target.clock_sync_trials },
            plan::ClockSync::On => {
                ClockSync::On { trials: plan.target.clock_sync_trials, attenuation: plan.target.clock_sync_attenuation }
            }
        },
        local_clock_sync: true,
        authentication: plan.target.authentication.then_some(lf_runtime::answer_rti),
        physical_delay: federate.physical_delay_ns.map(Interval::from_nanos),
        advance_interval: Interval::from_nanos(plan.target.advance_interval_ns),
        ..Federation::DEFAULT
    }
    .with_buffers(tables)
}
