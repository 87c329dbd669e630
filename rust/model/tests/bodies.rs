// SPDX-License-Identifier: Apache-2.0
//! The forms in which reaction bodies of Lingua Franca's Rust target use `ctx`, ports and actions.
//!
//! Proves that they compile against this crate's prelude and mean the same. The functions have the signatures that
//! the compiler generates, and bodies as users write them.
#![allow(clippy::pedantic, reason = "bodies are written as users write them")]
use crate::bench::{By, at, bench};
use lf_model::Schedulable;
use lf_model::prelude::*;

/// A value of some target code.
#[derive(Clone, Debug, PartialEq)]
struct Hello {
    name: String,
    value: i32,
}

/// Runs a body once, in a reaction to startup.
fn in_reaction(body: impl FnMut(&mut ReactionContext<'_>) + 'static) {
    let mut body = body;
    let mut bench = bench().reaction(0, &[By::Startup], move |_, ctx| body(ctx)).build();
    assert_eq!(bench.steps(1), [at(0, 0)]);
}

fn port<T>(id: u16) -> Port<T> {
    Port::new(lf_model::PortId(id))
}

#[test]
fn values_are_read_by_copy_by_reference_and_by_closure() {
    fn body(ctx: &mut ReactionContext<'_>, inp: &Port<u32>, hello: &Port<Hello>, absent: &Port<Hello>) {
        assert_eq!(ctx.get(inp), Some(5));
        match ctx.get(inp) {
            Some(0) | None => unreachable!(),
            Some(_) => {}
        }
        assert!(ctx.is_present(hello) && !ctx.is_present(absent));
        assert_eq!(ctx.get_ref(hello).unwrap().name, "Earth");
        assert!(ctx.use_ref(absent, |v| v.is_none()));
        assert!(ctx.use_ref(hello, |v| v.is_some()));
        let value = ctx.use_ref_opt(hello, |hello| hello.value);
        assert_eq!(value, Some(42));
        assert_eq!(ctx.use_ref_opt(absent, |hello| hello.value), None);
    }
    let (mut inp, mut hello, absent) = (port(0), port(1), port(2));
    in_reaction(move |ctx| {
        ctx.set(&mut inp, 5);
        ctx.set(&mut hello, Hello { name: "Earth".into(), value: 42 });
        body(ctx, &inp, &hello, &absent);
    });
}

#[test]
fn effects_can_be_set_and_read() {
    #[allow(clippy::useless_conversion)]
    fn body(ctx: &mut ReactionContext<'_>, inp: &Port<u32>, out: &mut Port<u32>, wide: &mut Port<f64>) {
        ctx.set(out, ctx.get(inp).unwrap());
        ctx.set(out, ctx.get(out).unwrap() + 1);
        ctx.set_opt(out, ctx.get(inp));
        ctx.set_opt(out, None);
        let count = 7u32;
        ctx.set(wide, count.into());
        assert_eq!((ctx.get(out), ctx.get(wide)), (Some(5), Some(7.0)));
        ctx.set(out, ctx.get_elapsed_physical_time().subsec_millis());
        ctx.set(out, 3)
    }
    let (mut inp, mut out, mut wide) = (port(0), port(1), port(2));
    in_reaction(move |ctx| {
        ctx.set(&mut inp, 5);
        body(ctx, &inp, &mut out, &mut wide);
    });
}

/// Generated code copies so for a connection in a mode, and takes for a body in C.
#[test]
fn a_port_takes_the_value_of_another_one_if_there_is_one() {
    let (mut from, absent, mut to) = (port::<u32>(0), port(1), port(2));
    in_reaction(move |ctx| {
        ctx.copy(&from, &mut to);
        assert!(!ctx.is_present(&to));
        ctx.set(&mut from, 5);
        ctx.copy(&from, &mut to);
        ctx.copy(&absent, &mut to);
        assert_eq!((ctx.get(&from), ctx.get(&to)), (Some(5), Some(5)));
        assert_eq!((to.take(), to.take()), (Some(5), None));
    });
}

#[test]
fn an_action_that_is_trigger_and_effect_can_be_read_and_scheduled_again_and_again() {
    fn body(ctx: &mut ReactionContext<'_>, act: &mut LogicalAction<u32>, physical: &mut PhysicalAction<u32>) {
        assert!(!ctx.is_present(act) && ctx.get(act).is_none());
        ctx.use_ref(act, |v| assert_eq!(v, None));
        ctx.schedule(act, Asap);
        ctx.schedule(act, after!(10 ms));
        ctx.schedule(act, After(delay!(3 usec)));
        ctx.schedule(physical, Asap);
        let act_ref: PhysicalActionRef<u32> = physical.clone();
        ctx.schedule_physical(&act_ref, Asap).ok();
        ctx.schedule_physical_with_v(&act_ref, Some(1), after!(1 sec)).unwrap();
        helper(physical);
        ctx.schedule_with_v(act, Some(100), Asap)
    }
    fn helper(_: &PhysicalActionRef<u32>) {}
    let mut bench = bench()
        .reaction(0, &[By::Startup], |cells, ctx| {
            // Bodies in C see queues so.
            assert_eq!([Schedulable::pending(&cells.actions[0]), Schedulable::pending(&cells.physical)], [None; 2]);
            body(ctx, &mut cells.actions[0], &mut cells.physical);
            assert_eq!(
                [Schedulable::pending(&cells.actions[0]), Schedulable::pending(&cells.physical)],
                [Some(at(0, 1)); 2]
            );
            assert_eq!([Schedulable::capacity(&cells.actions[0]), Schedulable::capacity(&cells.physical)], [4, 3]);
        })
        .build();
    bench.steps(1);
}

#[test]
fn times_are_instants_and_durations_like_those_of_std() {
    in_reaction(|ctx| {
        assert_tag_is!(ctx, T0);
        assert_tag_is!(ctx, (T0, 0));
        assert_tag_is!(ctx, (T0 + 0 ms, 0));
        let n = 0u64;
        assert_tag_is!(ctx, T0 + (40 * n) ms);
        let tag = ctx.get_tag();
        assert_eq!(format!("{} {} {}", tag, tag.offset_from_t0.as_nanos(), tag.microstep), "(T0 + 0 ns = 0 ms, 0) 0 0");
        assert!(ctx.get_elapsed_logical_time().is_zero());
        assert!(ctx.get_elapsed_logical_time() < Duration::from_millis(500));
        assert!(ctx.get_physical_time() - ctx.get_start_time() < delay!(1 sec) * 2);
        assert_eq!(ctx.get_logical_time() - ctx.get_start_time(), ctx.get_elapsed_logical_time());
        assert_eq!(ctx.get_elapsed_physical_time().as_millis(), 0);
        assert_eq!((ctx.num_workers(), ctx.get_federation_id()), (1, ""));
    });
}
