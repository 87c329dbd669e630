// SPDX-License-Identifier: Apache-2.0
//! Offsets compared with brute force on small graphs, and messages about programs.

use proptest::prelude::*;

use super::longest_paths::{Edge, LongestPaths};
use super::{Bounds, Offsets, parse_time};
use crate::plan::Plan;
use crate::{SourceProvider, compile};

/// The worst case of a message: it leaves federate i as late as it may, takes as long as it may, and meets a clock that
/// is as far ahead as it may be. It is in time if the receiver has not begun a tag after its own.
#[derive(Clone, Copy, Debug)]
struct Case {
    from: usize,
    to: usize,
    lag: i64,
    latency: i64,
    clock_error: i64,
    delay: i64,
}

impl Case {
    fn is_in_time(&self, offsets: &[i64]) -> bool {
        let tag = 1000;
        let sent_at = tag + offsets[self.from] + self.lag;
        let arrived_at = sent_at + self.latency + self.clock_error;
        let next_tag_begins_after = tag + self.delay + offsets[self.to];
        arrived_at <= next_tag_begins_after
    }

    fn edge(&self) -> Edge {
        let weight = self.lag + self.latency + self.clock_error - self.delay;
        Edge { from: self.from, to: self.to, weight }
    }
}

const FEDERATES: usize = 3;

/// More than any path of such graphs demands: two connections of at most 6 each.
const ENOUGH: i64 = 13;

fn cases() -> impl Strategy<Value = Vec<Case>> {
    let case = (0..FEDERATES, 0..FEDERATES, 0..=2_i64, 0..=2_i64, 0..=2_i64, 0..=8_i64);
    let case = case.prop_map(|(from, to, lag, latency, clock_error, delay)| Case {
        from,
        to,
        lag,
        latency,
        clock_error,
        delay,
    });
    prop::collection::vec(case.prop_filter("no federate sends to itself", |case| case.from != case.to), 0..6)
}

/// Returns all offsets up to [`ENOUGH`] with which every message is in time.
fn safe(cases: &[Case]) -> Vec<Vec<i64>> {
    let mut all = vec![Vec::new()];
    for _ in 0..FEDERATES {
        all = all.iter().flat_map(|start| (0..=ENOUGH).map(move |next| [&start[..], &[next]].concat())).collect();
    }
    all.retain(|offsets| cases.iter().all(|case| case.is_in_time(offsets)));
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// With the computed offsets no message is late, and every smaller offset makes one late.
    #[test]
    fn the_offsets_are_safe_and_no_smaller_ones_are(cases in cases()) {
        let edges: Vec<Edge> = cases.iter().map(Case::edge).collect();
        let paths = LongestPaths::of(FEDERATES, &edges);
        let safe = safe(&cases);
        if paths.cycles.is_empty() {
            let found: Vec<i64> = paths.offsets.iter().map(|offset| offset.expect("there is no cycle")).collect();
            prop_assert!(safe.contains(&found), "{found:?} is not safe");
            for other in &safe {
                prop_assert!(found.iter().zip(other).all(|(found, other)| found <= other), "{other:?} is safe too");
            }
        } else {
            prop_assert!(safe.is_empty(), "{:?} is safe", safe.first());
        }
    }

    /// A reported cycle is one, and it demands more in each round.
    #[test]
    fn cycles_without_enough_delay_are_named(cases in cases()) {
        let edges: Vec<Edge> = cases.iter().map(Case::edge).collect();
        let paths = LongestPaths::of(FEDERATES, &edges);
        for cycle in &paths.cycles {
            let next = cycle.iter().cycle().skip(1);
            prop_assert!(cycle.iter().zip(next).all(|(one, next)| edges[*one].to == edges[*next].from));
            prop_assert!(cycle.iter().map(|edge| edges[*edge].weight).sum::<i64>() > 0);
        }
        prop_assert_eq!(paths.cycles.is_empty(), paths.offsets.iter().all(Option::is_some));
    }

    /// The connections on the path of an offset add up to it.
    #[test]
    fn the_path_explains_the_offset(cases in cases()) {
        let edges: Vec<Edge> = cases.iter().map(Case::edge).collect();
        let paths = LongestPaths::of(FEDERATES, &edges);
        for (node, offset) in paths.offsets.iter().enumerate() {
            let path = paths.path(node, &edges);
            let Some(offset) = offset else {
                prop_assert!(path.is_empty());
                continue;
            };
            prop_assert_eq!(path.iter().map(|edge| edges[*edge].weight).sum::<i64>(), *offset);
            prop_assert!(path.last().is_none_or(|last| edges[*last].to == node));
            prop_assert!(path.windows(2).all(|pair| edges[pair[0]].to == edges[pair[1]].from));
        }
    }
}

struct One(&'static str);

impl SourceProvider for One {
    fn read(&self, _: &str) -> Result<String, String> {
        Ok(self.0.to_owned())
    }
}

fn plan(text: &'static str) -> Plan {
    let compilation = compile("Program.lf", &One(text));
    compilation.plan.unwrap_or_else(|| panic!("{}", compilation.diagnostics.render(crate::Style::Plain)))
}

const PARTS: &str = "
    reactor Source { output y: u32 timer t(0, 10 ms) reaction(t) -> y {= =} }
    reactor Filter { input x: u32 output y: u32 reaction(x) -> y {= =} }
    reactor Sink { input x: u32 timer t(0, 3 ms) reaction(x) {= =} reaction(t) {= =} deadline(13 ms) {= =} }
    reactor Both { input x: u32 output y: u32 timer t(0, 10 ms) reaction(t) -> y {= =} reaction(x) {= =} }
";

fn program(federated: &str) -> Plan {
    let text = format!("target Rust {{ coordination: decentralized }} {PARTS} federated reactor {{ {federated} }}");
    plan(Box::leak(text.into_boxed_str()))
}

const BOUNDS: &str = "latency: 5 ms\nclock-error: 100 us\nexecution: 200 us\n";

fn offsets(plan: &Plan, bounds: &str) -> Offsets {
    let bounds = Bounds::parse("bounds.yaml", bounds, plan).unwrap_or_else(|errors| panic!("{errors:?}"));
    Offsets::of(plan, &bounds).unwrap_or_else(|missing| panic!("{missing:?}"))
}

#[test]
fn a_chain_adds_up_and_says_how() {
    let chain =
        program("a = new Source() b = new Filter() @maxwait(10 ms) c = new Sink() a.y -> b.x b.y -> c.x after 1 ms");
    insta::assert_snapshot!(offsets(&chain, BOUNDS));
}

#[test]
fn a_wait_that_is_long_enough_is_not_named_and_one_for_ever_is_no_bound() {
    // The filter only forwards messages, so it is no later than they are, however long it waits.
    let enough = "a = new Source() b = new Filter() @maxwait(11 ms) c = new Sink() a.y -> b.x b.y -> c.x";
    assert_eq!(offsets(&program(enough), BOUNDS).short_waits, []);
    // A federate with a timer of its own waits without end before its tags.
    let no_bound = "a = new Source() b = new Both() @maxwait(11 ms) c = new Sink() a.y -> b.x b.y -> c.x";
    let found = offsets(&program(no_bound), BOUNDS);
    assert_eq!(found.short_waits.iter().map(|wait| wait.needed_ns).collect::<Vec<_>>(), [None]);
}

#[test]
fn a_cycle_needs_as_much_delay_as_a_round_takes() {
    let cycle = "@maxwait(0) a = new Both() @maxwait(0) b = new Both() @absent_after(100 ms) a.y -> b.x b.y -> a.x";
    insta::assert_snapshot!(offsets(&program(cycle), BOUNDS));
    let delayed = "a = new Both() b = new Both() a.y -> b.x after 5500 us b.y -> a.x after 5500 us";
    let found = offsets(&program(delayed), BOUNDS);
    assert!(found.federates.iter().all(|federate| federate.offset_ns == Some(0)), "{found}");
}

#[test]
fn a_queue_that_cannot_hold_what_comes_during_a_wait_is_named() {
    let ample = "a = new Source() @maxwait(2 s) b = new Sink() a.y -> b.x";
    assert_eq!(offsets(&program(ample), BOUNDS).overflows, []);
    let small = "a = new Source() @maxwait(2 s) b = new Sink() @capacity(50) a.y -> b.x";
    let found = offsets(&program(small), BOUNDS);
    assert!(!found.is_safe());
    insta::assert_snapshot!(found);
    // The capacity follows the wait, but only up to a limit; and the program's wait may differ from the necessary one.
    let long = "a = new Source() @maxwait(10 s) b = new Sink() a.y -> b.x";
    let counts = |found: &Offsets| found.overflows.iter().map(|it| (it.messages, it.capacity)).collect::<Vec<_>>();
    assert_eq!(counts(&offsets(&program(long), BOUNDS)), [(1001, 264)]);
    let late = "a = new Source() @maxwait(0) b = new Sink() a.y -> b.x";
    assert_eq!(counts(&offsets(&program(late), "latency: 10 s\nclock-error: 0\nexecution: 0\n")), [(1001, 264)]);
}

#[test]
fn more_precise_bounds_go_first() {
    let plan =
        program("a = new Source() at 10.0.0.1 b = new Filter() at 10.0.0.2 c = new Sink() a.y -> b.x b.y -> c.x");
    let bounds = "latency: 5 ms\nclock-error: 100 us\n\
        hosts:\n  - { between: [10.0.0.2, 10.0.0.1], latency: 2 ms }\n\
        connections: { 'b.y -> c.x': 1.5 ms }\n\
        federates: { a: { clock-error: 10 us, lag: 3 ms }, b: { clock-error: 20 us } }\n\
        reactors: { Filter: 1 ms, Sink: 0 }\n";
    let found = offsets(&plan, bounds);
    let parts = |connection: &super::Connection| (connection.lag_ns, connection.latency_ns, connection.clock_error_ns);
    let parts: Vec<_> = found.connections.iter().map(parts).collect();
    assert_eq!(parts, [(3_000_000, 2_000_000, 30_000), (1_000_000, 1_500_000, 100_000)]);
}

#[test]
fn bounds_that_are_missing_are_named_once() {
    let plan = program("a = new Source() b = new Filter() c = new Sink() a.y -> b.x b.y -> c.x");
    let missing = Offsets::of(&plan, &Bounds::default()).expect_err("nothing is bounded");
    let said: Vec<String> = missing.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn mistakes_in_a_file_of_bounds_are_shown_at_their_places() {
    let plan = program("a = new Source() b = new Filter() a.y -> b.x");
    let text = "latency: 5\nclock-error: 1 parsec\n\
        hosts:\n  - { between: [localhost], latency: 1 ms }\n  - { between: [localhost, elsewhere], latency: 1 ms }\n\
        connections: { 'a.y -> b.y': 1.5 ms }\nfederates: { c: { lag: -3 ms } }\n\
        reactors: { Filtre: 1 ms }\nreactions: { b.reaction_2: 1 ms }\n";
    let errors = Bounds::parse("bounds.yaml", text, &plan).expect_err("much is wrong");
    let said: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let unknown = Bounds::parse("bounds.yaml", "jitter: 1 ms", &plan).expect_err("there is no such key");
    insta::assert_snapshot!(format!("{}\n{}", said.join("\n"), unknown[0]));
}

#[test]
fn a_file_of_bounds_that_was_written_says_the_same() {
    let plan = program("a = new Source() at 10.0.0.1 b = new Filter() a.y -> b.x");
    let text = "latency: 5 ms\nclock-error: 100 us\nexecution: 1234567 ns\n\
        hosts:\n  - { between: [localhost, 10.0.0.1], latency: 2 ms }\nconnections: { 'a.y -> b.x': 1500 us }\n\
        federates: { a: { clock-error: 10 us, lag: 3 ms } }\nreactors: { Filter: 1 ms }\n\
        reactions: { b.reaction_1: 0 }\n";
    let bounds = Bounds::parse("bounds.yaml", text, &plan).expect("it is right");
    assert_eq!(Bounds::parse("bounds.yaml", &bounds.to_yaml(), &plan), Ok(bounds));
    assert_eq!(Bounds::parse("bounds.yaml", "# nothing\n", &plan), Ok(Bounds::default()));
}

#[test]
fn times_have_units_and_fractions() {
    assert_eq!(parse_time("1.25 ms"), Ok(1_250_000));
    assert_eq!(parse_time(" 3us "), Ok(3_000));
    assert_eq!(parse_time("0"), Ok(0));
    for wrong in ["", "5", "-1 ms", "1.2.3 ms", "1 fortnight", ".5 s", "99999999999 s"] {
        assert!(parse_time(wrong).is_err(), "{wrong}");
    }
}
