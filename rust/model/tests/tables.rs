// SPDX-License-Identifier: Apache-2.0
//! Tables that contradict themselves are refused, which is at compile time in generated code.
use lf_model::{
    InputId, Interval, ModeEvents, ModeId, ModeInfo, ModeTrigger, Modes, NetworkInput, NetworkOutput, OutputId,
    PayloadError, PortId, PortInfo, Program, ReactionContext, ReactionId, ReactionInfo, ReactionKind, Tables, Tag,
    TriggerCell, TriggerId, TriggerInfo, TriggerKind, Undelivered, storage_for, words,
};

const fn reaction(level: u16, kind: ReactionKind) -> ReactionInfo {
    ReactionInfo { name: "r", level, deadline: None, tardy: false, kind }
}

const fn port(reactions: &'static [ReactionId], delays: &'static [TriggerId]) -> PortInfo {
    PortInfo { name: "p", reactions, delays }
}

const DELAY: TriggerKind = TriggerKind::Delay { fills: PortId(0), delay: Interval::ZERO };

const GOOD: Tables = Tables {
    reactions: &[reaction(0, ReactionKind::Body), reaction(1, ReactionKind::Send(OutputId(0)))],
    triggers: &[
        TriggerInfo { name: "startup", kind: TriggerKind::Startup, reactions: &[ReactionId(0)] },
        TriggerInfo { name: "d", kind: DELAY, reactions: &[] },
        TriggerInfo { name: "n", kind: TriggerKind::NetworkInput { fills: PortId(1) }, reactions: &[] },
    ],
    ports: &[port(&[ReactionId(1)], &[]), port(&[], &[TriggerId(1)])],
    outputs: &[NetworkOutput {
        name: "o",
        source: PortId(0),
        federate: 1,
        port: 0,
        delay: None,
        max_len: 4,
        tells_absence: true,
        physical: false,
    }],
    inputs: &[NetworkInput {
        name: "i",
        trigger: TriggerId(2),
        federate: 1,
        max_len: 4,
        awaited: true,
        ..NetworkInput::DEFAULT
    }],
    absence: &[ReactionId(1)],
    ..Tables::DEFAULT
};
const _: () = GOOD.check();

/// Returns the sentence with which the tables are refused.
fn refusal(tables: Tables) -> String {
    let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(move || tables.check())).unwrap_err();
    (*panic.downcast::<&str>().unwrap()).to_string()
}

#[test]
fn each_contradiction_is_named() {
    let body = ReactionKind::Body;
    let reactions: &[ReactionInfo] = Box::leak(Box::new([reaction(1, body), reaction(0, body)]));
    assert_eq!(refusal(Tables { reactions, ..GOOD }), "reactions are not in order of level");
    assert_eq!(refusal(Tables { outputs: &[], ..GOOD }), "a reaction sends to an output that does not exist");
    assert_eq!(refusal(Tables { ports: &[], ..GOOD }), "a trigger fills a port that does not exist");
    let with_ports = |ports: [PortInfo; 2]| refusal(Tables { ports: Box::leak(Box::new(ports)), ..GOOD });
    let wrong_kind = with_ports([port(&[], &[TriggerId(0)]), port(&[], &[])]);
    assert_eq!(wrong_kind, "a port is delayed by a trigger of another kind");
    let unknown = with_ports([port(&[], &[TriggerId(9)]), port(&[], &[])]);
    assert_eq!(unknown, "a port is delayed by a trigger that does not exist");
    assert_eq!(
        with_ports([port(&[ReactionId(9)], &[]), port(&[], &[])]),
        "a reaction that does not exist is triggered"
    );
    let with_trigger = |kind, reactions| {
        let mut triggers = GOOD.triggers.to_vec();
        triggers[2] = TriggerInfo { name: "x", kind, reactions };
        refusal(Tables { triggers: triggers.leak(), ..GOOD })
    };
    assert_eq!(with_trigger(DELAY, &[ReactionId(0)]), "a trigger that fills a port has reactions of its own");
    assert_eq!(with_trigger(DELAY, &[]), "an input's trigger is of another kind");
    assert_eq!(with_trigger(TriggerKind::Startup, &[ReactionId(9)]), "a reaction that does not exist is triggered");
    let output = NetworkOutput { source: PortId(9), ..GOOD.outputs[0] };
    assert_eq!(refusal(Tables { outputs: Box::leak(Box::new([output])), ..GOOD }), "an output's source does not exist");
    let silent = NetworkOutput { tells_absence: false, ..GOOD.outputs[0] };
    assert_eq!(
        refusal(Tables { outputs: Box::leak(Box::new([silent])), ..GOOD }),
        "a reaction tells absence, but does not send an output that does"
    );
    let absence = |ids: &'static [ReactionId]| refusal(Tables { absence: ids, ..GOOD });
    assert_eq!(absence(&[ReactionId(0)]), "a reaction tells absence, but does not send an output that does");
    assert_eq!(absence(&[ReactionId(2)]), "a reaction that does not exist tells absence");
    let input = NetworkInput { trigger: TriggerId(9), ..GOOD.inputs[0] };
    assert_eq!(refusal(Tables { inputs: Box::leak(Box::new([input])), ..GOOD }), "an input's trigger does not exist");
    assert_eq!(refusal(Tables { own_ports: &[1, 1], ..GOOD }), "port numbers of its own are not in order");
    assert_eq!(refusal(Tables { own_ports: &[0, 2, 1], ..GOOD }), "port numbers of its own are not in order");
}

#[test]
fn modes_that_do_not_exist_are_named() {
    const MODE: ModeInfo = ModeInfo { name: "m", instance: 0, parent: None, initial: true };
    const NO_EVENTS: ModeEvents = ModeEvents { entry: TriggerId(0), startup: &[], reset: &[], shutdown: &[] };
    let trigger = |trigger, mode| ModeTrigger { trigger: TriggerId(trigger), mode: ModeId(mode), offset: None };
    let check = |modes: &[ModeInfo], reactions: &[Option<ModeId>], triggers: &[ModeTrigger], entry| {
        let events = ModeEvents { entry: TriggerId(entry), ..NO_EVENTS };
        let modes = Modes::new(modes.to_vec().leak(), reactions.to_vec().leak(), triggers.to_vec().leak(), events);
        Tables { modes: Some(Box::leak(Box::new(modes))), ..GOOD }
    };
    let inner = ModeInfo { parent: Some(ModeId(0)), ..MODE };
    check(&[MODE, inner], &[None, Some(ModeId(1))], &[trigger(2, 1)], 2).check();
    let refused =
        |modes: &[ModeInfo], reactions: &[_], triggers: &[_], entry| refusal(check(modes, reactions, triggers, entry));
    assert_eq!(refused(&[MODE], &[None], &[], 0), "not every reaction says in which mode it is");
    assert_eq!(refused(&[MODE], &[None; 2], &[], 3), "modes are entered by a trigger that does not exist");
    assert_eq!(refused(&[inner], &[None; 2], &[], 0), "a mode comes before the one that contains it");
    let outside = [None, Some(ModeId(1))];
    assert_eq!(refused(&[MODE], &outside, &[], 0), "a reaction is in a mode that does not exist");
    assert_eq!(refused(&[MODE], &[None; 2], &[trigger(0, 1)], 0), "a trigger is in a mode that does not exist");
    assert_eq!(refused(&[MODE], &[None; 2], &[trigger(3, 0)], 0), "a trigger that does not exist is in a mode");
}

#[test]
fn inputs_are_found_by_their_ports_past_those_that_are_left_out() {
    let tables = |own_ports| Tables { inputs: Box::leak(Box::new([GOOD.inputs[0]; 3])), own_ports, ..GOOD };
    Tables { own_ports: &[0, 2, 4], ..GOOD }.check();
    let own_ports: [&[u16]; 4] = [&[], &[0], &[1, 2], &[0, 2, 4]];
    for (own_ports, expected) in own_ports.into_iter().zip([[0, 1, 2], [1, 2, 3], [0, 3, 4], [1, 3, 5]]) {
        let tables = tables(own_ports);
        assert_eq!([0, 1, 2].map(|input| tables.port_of(InputId(input))), expected);
        for port in 0..8 {
            let input = (0..).zip(expected).find(|(_, of)| *of == port).map(|(input, _)| InputId(input));
            assert_eq!(tables.input_of(port), input, "{own_ports:?}: {port}");
        }
    }
}

#[test]
fn storage_has_the_size_of_the_tables() {
    assert_eq!([words(0), words(1), words(32), words(33)], [0, 1, 1, 2]);
    // Three triggers of a tag and a place in the tree each, and three words of bits.
    assert_eq!(size_of::<storage_for!(GOOD)>(), (3 * (16 + 2) + 3 * 4_usize).next_multiple_of(8));
}

/// A program that sends and receives nothing.
struct Silent;

impl Program for Silent {
    fn tables(&self) -> &'static Tables {
        &GOOD
    }
    fn react(&mut self, _reaction: ReactionId, _ctx: &mut ReactionContext<'_>) {}
    fn clear_port(&mut self, _port: PortId) {}
    fn trigger(&mut self, _trigger: TriggerId) -> Option<&mut dyn TriggerCell> {
        None
    }
}

#[test]
fn what_a_program_does_not_have_is_refused() {
    let (mut program, tag) = (Silent, Tag::NEVER);
    assert_eq!(program.encode(OutputId(0), &mut []), Err(PayloadError::Absent));
    assert_eq!(program.hand_over(0, &mut []), Err(PayloadError::Absent));
    assert_eq!(program.take_over(0, &[]), Err(PayloadError::Absent));
    assert!(matches!(program.deliver(InputId(0), tag, &[]), Err(Undelivered::NoSuchPort)));
    assert!(matches!(program.deliver_tardy(InputId(0), tag, tag, &[]), Err(Undelivered::NoSuchPort)));
    assert!(program.capture(TriggerId(0), tag).is_ok());
}
