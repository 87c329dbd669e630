// SPDX-License-Identifier: Apache-2.0
//! Tables that contradict themselves are refused, which is at compile time in generated code.
use lf_model::{
    InputId, Interval, NetworkInput, NetworkOutput, OutputId, PortId, PortInfo, ReactionId, ReactionInfo, ReactionKind,
    Tables, TriggerId, TriggerInfo, TriggerKind, storage_for, words,
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
}

#[test]
fn inputs_are_found_by_their_ports_past_those_that_are_left_out() {
    let tables = |own_ports| Tables { inputs: Box::leak(Box::new([GOOD.inputs[0]; 3])), own_ports, ..GOOD };
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
