// SPDX-License-Identifier: Apache-2.0
//! The constant part of a federate: numbers of its parts, tables, and the description for the event loop.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Module;
use crate::emit::EmitError;
use crate::emit::reactor::integer;
use crate::plan::{
    Argument, ClockSync, Coordination, InputIndex, Logging, OutputIndex, Plan, PortIndex, ReactionIndex, ReactionKind,
    Rti, SpacingPolicy, Trigger, TriggerIndex, TriggerKind,
};

impl Module<'_> {
    /// Names for the numbers of reactions, triggers, ports, outputs and inputs.
    pub(super) fn constants(&mut self) -> TokenStream {
        let mut constants = TokenStream::new();
        let numbers = |len: usize| (0..len).map(Literal::usize_unsuffixed);
        for (index, number) in numbers(self.federate.reactions.len()).enumerate() {
            let name = self.symbols.reaction_id(ReactionIndex(index));
            constants.extend(quote! { const #name: ReactionId = ReactionId(#number); });
        }
        for (index, number) in numbers(self.federate.triggers.len()).enumerate() {
            let name = self.symbols.trigger_id(TriggerIndex(index));
            constants.extend(quote! { const #name: TriggerId = TriggerId(#number); });
        }
        for (index, number) in numbers(self.federate.ports.len()).enumerate() {
            let name = self.symbols.port_id(PortIndex(index));
            constants.extend(quote! { const #name: PortId = PortId(#number); });
        }
        for (index, number) in numbers(self.federate.outputs.len()).enumerate() {
            let name = self.symbols.output_id(OutputIndex(index));
            constants.extend(quote! { const #name: OutputId = OutputId(#number); });
        }
        for (index, number) in numbers(self.federate.inputs.len()).enumerate() {
            let name = self.symbols.input_id(InputIndex(index));
            constants.extend(quote! { const #name: InputId = InputId(#number); });
        }
        constants
    }

    /// The tables, checked when they are compiled.
    pub(super) fn tables(&mut self) -> Result<TokenStream, EmitError> {
        let reactions = self.reaction_table();
        let triggers = self.trigger_table();
        let ports = self.port_table();
        let (outputs, inputs) = (self.output_table()?, self.input_table()?);
        let absence = self.reaction_ids(&self.federate.absence());
        Ok(quote! {
            /// What the engine knows of this program.
            pub const TABLES: Tables = Tables {
                reactions: &[#(#reactions),*],
                triggers: &[#(#triggers),*],
                ports: &[#(#ports),*],
                outputs: &[#(#outputs),*],
                inputs: &[#(#inputs),*],
                absence: #absence,
            };
            const _: () = TABLES.check();
            /// The memory that the engine needs for it.
            pub type Storage = lf::model::storage_for!(TABLES);
        })
    }

    fn reaction_table(&self) -> Vec<TokenStream> {
        let row = |reaction: &crate::plan::ScheduledReaction| {
            let (name, level) = (&reaction.name, Literal::u16_unsuffixed(reaction.level));
            let deadline = optional_interval(reaction.deadline_ns);
            let kind = match &reaction.kind {
                ReactionKind::Body { .. } => quote!(ReactionKind::Body),
                ReactionKind::Send(output) => {
                    let output = self.symbols.output_id(*output);
                    quote!(ReactionKind::Send(#output))
                }
            };
            let tardy = self.plan.tardy(self.federate, reaction).is_some();
            quote! { ReactionInfo { name: #name, level: #level, deadline: #deadline, tardy: #tardy, kind: #kind } }
        };
        self.federate.reactions.iter().map(row).collect()
    }

    fn trigger_table(&self) -> Vec<TokenStream> {
        let row = |trigger: &Trigger| {
            let name = &trigger.path;
            let kind = self.trigger_kind(&trigger.kind);
            let reactions = self.reaction_ids(&trigger.reactions);
            quote! { TriggerInfo { name: #name, kind: #kind, reactions: #reactions } }
        };
        self.federate.triggers.iter().map(row).collect()
    }

    fn trigger_kind(&self, kind: &TriggerKind) -> TokenStream {
        match kind {
            TriggerKind::Startup => quote!(TriggerKind::Startup),
            TriggerKind::Shutdown => quote!(TriggerKind::Shutdown),
            TriggerKind::Timer { offset_ns, period_ns, .. } => {
                let (offset, period) = (interval(*offset_ns), interval(period_ns.unwrap_or(0)));
                quote!(TriggerKind::Timer { offset: #offset, period: #period })
            }
            TriggerKind::Action { physical, min_delay_ns, min_spacing_ns, policy, .. } => {
                let (min_delay, min_spacing) = (interval(*min_delay_ns), optional_interval(*min_spacing_ns));
                let policy = match policy {
                    SpacingPolicy::Defer => quote!(Policy::Defer),
                    SpacingPolicy::Drop => quote!(Policy::Drop),
                    SpacingPolicy::Replace => quote!(Policy::Replace),
                    SpacingPolicy::Update => quote!(Policy::Update),
                };
                let kind = if *physical { quote!(Physical) } else { quote!(Logical) };
                quote! {
                    TriggerKind::#kind(ActionTiming {
                        min_delay: #min_delay,
                        min_spacing: #min_spacing,
                        policy: #policy,
                    })
                }
            }
            TriggerKind::Delay { fills, delay_ns, physical, .. } => {
                let (fills, delay) = (self.symbols.port_id(*fills), interval(*delay_ns));
                let kind = if *physical { quote!(PhysicalDelay) } else { quote!(Delay) };
                quote!(TriggerKind::#kind { fills: #fills, delay: #delay })
            }
            TriggerKind::NetworkInput { fills, .. } => {
                let fills = self.symbols.port_id(*fills);
                quote!(TriggerKind::NetworkInput { fills: #fills })
            }
        }
    }

    fn port_table(&self) -> Vec<TokenStream> {
        let row = |port: &crate::plan::Port| {
            let name = &port.path;
            let reactions = self.reaction_ids(&port.reactions);
            let delays = port.delays.iter().map(|trigger| self.symbols.trigger_id(*trigger));
            quote! { PortInfo { name: #name, reactions: #reactions, delays: &[#(#delays),*] } }
        };
        self.federate.ports.iter().map(row).collect()
    }

    fn output_table(&self) -> Result<Vec<TokenStream>, EmitError> {
        let row = |output: &crate::plan::NetworkOutput| {
            let (name, source) = (&output.name, self.symbols.port_id(output.source));
            let (federate, port) = (Literal::u16_unsuffixed(output.federate), Literal::u16_unsuffixed(output.port));
            let (delay, max_len) = (optional_interval(output.delay_ns), self.max_len(output.source)?);
            let (tells_absence, physical) = (output.tells_absence, output.physical);
            Ok(quote! {
                NetworkOutput {
                    name: #name,
                    source: #source,
                    federate: #federate,
                    port: #port,
                    delay: #delay,
                    max_len: #max_len,
                    tells_absence: #tells_absence,
                    physical: #physical,
                }
            })
        };
        self.federate.outputs.iter().map(row).collect()
    }

    fn input_table(&self) -> Result<Vec<TokenStream>, EmitError> {
        let row = |input: &crate::plan::NetworkInput| {
            let (name, trigger) = (&input.name, self.symbols.trigger_id(input.trigger));
            let federate = Literal::u16_unsuffixed(input.federate);
            let (delay, max_len) = (optional_interval(input.delay_ns), self.max_len(self.filled(input.trigger))?);
            let (level, awaited, physical) = (Literal::u16_unsuffixed(input.level), input.awaited, input.physical);
            let tardy = self.can_be_tardy(input);
            let (max_wait, absent_after) = (interval(input.max_wait_ns), interval(input.absent_after_ns));
            let readers = if tardy { self.readers(self.filled(input.trigger)) } else { Vec::new() };
            let readers = self.reaction_ids(&readers);
            Ok(quote! {
                NetworkInput {
                    name: #name,
                    trigger: #trigger,
                    federate: #federate,
                    delay: #delay,
                    max_len: #max_len,
                    level: #level,
                    awaited: #awaited,
                    physical: #physical,
                    tardy: #tardy,
                    max_wait: #max_wait,
                    absent_after: #absent_after,
                    readers: #readers,
                }
            })
        };
        self.federate.inputs.iter().map(row).collect()
    }

    fn reaction_ids(&self, reactions: &[ReactionIndex]) -> TokenStream {
        let ids = reactions.iter().map(|reaction| self.symbols.reaction_id(*reaction));
        quote!(&[#(#ids),*])
    }

    /// The reactions that see a port and are not triggered by it.
    fn readers(&self, port: PortIndex) -> Vec<ReactionIndex> {
        let triggered = &self.federate.ports[port.0].reactions;
        let reads = |reaction: &crate::plan::ScheduledReaction| match &reaction.kind {
            ReactionKind::Body { arguments, .. } => arguments.contains(&Argument::Port(port)),
            ReactionKind::Send(_) => false,
        };
        let all = self.federate.reactions.iter().enumerate();
        let readers = all.filter(|(_, reaction)| reads(reaction)).map(|(index, _)| ReactionIndex(index));
        readers.filter(|index| !triggered.contains(index)).collect()
    }

    /// The port that a network input fills.
    fn filled(&self, trigger: TriggerIndex) -> PortIndex {
        match self.federate.triggers[trigger.0].kind {
            TriggerKind::Delay { fills, .. } | TriggerKind::NetworkInput { fills, .. } => fills,
            // A plan has no inputs with other triggers; the tables' own check would find one.
            _ => PortIndex(0),
        }
    }

    fn max_len(&self, port: PortIndex) -> Result<TokenStream, EmitError> {
        let ty = self.port_type(port)?;
        Ok(quote!(<#ty as Payload>::MAX_LEN))
    }

    /// What the event loop knows of this program.
    pub(super) fn description(&mut self) -> Result<TokenStream, EmitError> {
        let (program, name) = (&self.plan.name, &self.federate.name);
        let target = &self.plan.target;
        let timeout = optional_interval(target.timeout_ns);
        let (keepalive, fast) = (target.keepalive, target.fast);
        let logging = log_level(target.logging);
        let federation = match &self.rti {
            None => quote!(None),
            Some(rti) => self.federation(rti),
        };
        let longest = self.longest_payloads()?;
        Ok(quote! {
            #longest
            /// What the event loop knows of this program.
            pub static DESCRIPTION: lf::runtime::Description = lf::runtime::Description {
                program: #program,
                name: #name,
                timeout: #timeout,
                keepalive: #keepalive,
                fast: #fast,
                logging: lf::log::LevelFilter::#logging,
                federation: #federation,
            };
        })
    }

    fn federation(&self, rti: &Rti) -> TokenStream {
        let federate = self.federate;
        let id = Literal::u16_unsuffixed(federate.id);
        let federates = Literal::usize_unsuffixed(self.plan.federates.len());
        let authenticates = self.plan.target.authentication;
        let authentication = if authenticates { quote!(Some(lf::runtime::answer_rti)) } else { quote!(None) };
        let (federation_id, host, port) = (&rti.federation_id, &rti.host, Literal::u16_unsuffixed(rti.port));
        let upstream = federate.upstream.iter().map(|upstream| {
            let id = Literal::u16_unsuffixed(upstream.federate);
            let delay = upstream.delay_ns.map_or_else(|| quote!(lf::runtime::DELAY_NONE), integer);
            quote!((#id, #delay))
        });
        let downstream = federate.downstream.iter().map(|id| Literal::u16_unsuffixed(*id));
        let awaited = federate.inputs.iter().enumerate().filter(|(_, input)| input.awaited).map(|(port, input)| {
            let (port, level) = (Literal::usize_unsuffixed(port), Literal::u16_unsuffixed(input.level));
            quote!(lf::runtime::AwaitedInput { port: #port, level: #level })
        });
        let ids = |peers: Vec<u16>| peers.into_iter().map(Literal::u16_unsuffixed).collect::<Vec<_>>();
        let (peers_in, peers_out) = (ids(federate.peers_in()), ids(federate.peers_out()));
        let clock_sync = match self.plan.target.clock_sync {
            ClockSync::Off => quote!(lf::runtime::ClockSync::Off),
            ClockSync::Init => {
                let trials = clock_sync_trials(self.plan);
                quote!(lf::runtime::ClockSync::Init { trials: #trials })
            }
            ClockSync::On => {
                let trials = clock_sync_trials(self.plan);
                let attenuation = Literal::u16_unsuffixed(self.plan.target.clock_sync_attenuation);
                quote!(lf::runtime::ClockSync::On { trials: #trials, attenuation: #attenuation })
            }
        };
        let coordination = match self.plan.target.coordination {
            Coordination::Centralized => quote!(Centralized),
            Coordination::Decentralized => quote!(Decentralized),
        };
        let local_clock_sync = self.plan.target.clock_sync_local || self.rti_is_image;
        // As in LF, each federate's clock is wrong by another time.
        let times = i64::from(federate.id) + 1;
        let test_offset = interval(self.plan.target.clock_sync_test_offset_ns.saturating_mul(times));
        let physical_delay = optional_interval(federate.physical_delay_ns);
        let advance_interval = interval(self.plan.target.advance_interval_ns);
        let log_waits = optional_interval(self.plan.target.log_waits_ns);
        quote! {
            Some(lf::runtime::Federation {
                id: #id,
                federation_id: #federation_id,
                authentication: #authentication,
                coordination: lf::runtime::Coordination::#coordination,
                federates: #federates,
                rti_host: #host,
                rti_port: #port,
                upstream: &[#(#upstream),*],
                downstream: &[#(#downstream),*],
                awaited: &[#(#awaited),*],
                peers_in: &[#(#peers_in),*],
                peers_out: &[#(#peers_out),*],
                clock_sync: #clock_sync,
                local_clock_sync: #local_clock_sync,
                test_offset: #test_offset,
                physical_delay: #physical_delay,
                advance_interval: #advance_interval,
                log_waits: #log_waits,
                input_bytes: INPUT_BYTES,
                output_bytes: OUTPUT_BYTES,
                peer_input_bytes: PEER_INPUT_BYTES,
                peer_output_bytes: PEER_OUTPUT_BYTES,
            })
        }
    }

    /// Constants for the longest payload of each direction, of a federate.
    fn longest_payloads(&self) -> Result<TokenStream, EmitError> {
        if !self.plan.is_federated() {
            return Ok(TokenStream::new());
        }
        let of = |ports: Vec<PortIndex>| -> Result<Vec<TokenStream>, EmitError> {
            let mut lengths = Vec::new();
            for port in ports {
                let length = self.max_len(port)?;
                if !lengths.iter().any(|known: &TokenStream| known.to_string() == length.to_string()) {
                    lengths.push(length);
                }
            }
            Ok(lengths)
        };
        let federate = self.federate;
        let inputs = |direct: bool| {
            let inputs = federate.inputs.iter().filter(|input| input.direct == direct);
            of(inputs.map(|input| self.filled(input.trigger)).collect())
        };
        let outputs = |direct: bool| {
            of(federate.outputs.iter().filter(|output| output.direct == direct).map(|output| output.source).collect())
        };
        let (peer_inputs, peer_outputs) = (inputs(true)?, outputs(true)?);
        let (inputs, outputs) = (inputs(false)?, outputs(false)?);
        let neighbors = self.federate.upstream.len() + self.federate.downstream.len();
        let neighbors = Literal::usize_unsuffixed(neighbors);
        Ok(quote! {
            /// Bytes that the receive buffer needs.
            pub const INPUT_BYTES: usize = lf::runtime::buffer_bytes(longest(&[#(#inputs),*]), #neighbors);
            /// Bytes that the send buffer needs.
            pub const OUTPUT_BYTES: usize = lf::runtime::buffer_bytes(longest(&[#(#outputs),*]), #neighbors);
            const PEER_INPUT_BYTES: usize = lf::runtime::peer_buffer_bytes(longest(&[#(#peer_inputs),*]));
            const PEER_OUTPUT_BYTES: usize = lf::runtime::peer_buffer_bytes(longest(&[#(#peer_outputs),*]));
            const fn longest(lengths: &[usize]) -> usize {
                let mut longest = 0;
                let mut index = 0;
                while index < lengths.len() {
                    if lengths[index] > longest {
                        longest = lengths[index];
                    }
                    index += 1;
                }
                longest
            }
        })
    }
}

/// The log level, as the `log` crate calls it.
pub(in crate::emit) fn log_level(logging: Logging) -> TokenStream {
    match logging {
        Logging::Error => quote!(Error),
        Logging::Warn => quote!(Warn),
        Logging::Info => quote!(Info),
        Logging::Log => quote!(Debug),
        Logging::Debug => quote!(Trace),
    }
}

/// How many exchanges there are before the start.
pub(in crate::emit) fn clock_sync_trials(plan: &Plan) -> Literal {
    Literal::u16_unsuffixed(plan.target.clock_sync_trials)
}

/// An interval as a constant expression.
pub(in crate::emit) fn interval(ns: i64) -> TokenStream {
    match ns {
        0 => quote!(Interval::ZERO),
        i64::MAX => quote!(Interval::FOREVER),
        _ => {
            let ns = integer(ns);
            quote!(Interval::from_nanos(#ns))
        }
    }
}

pub(in crate::emit) fn optional_interval(ns: Option<i64>) -> TokenStream {
    match ns {
        None => quote!(None),
        Some(ns) => {
            let interval = interval(ns);
            quote!(Some(#interval))
        }
    }
}
