// SPDX-License-Identifier: Apache-2.0
//! Programs of micro LF: bodies find the API of reactor-uc.

use std::process::Command;

use crate::support::{folder, said, text};

/// Each function of the API, in bodies and in a preamble that includes the header of LF's older API.
const API: &str = r#"
preamble {=
    #include <stdio.h>
    #include "reactor-uc/reactor-c.h"
    typedef struct { int number; } point_t;
=}
reactor Source {
    output number: int
    output nothing: void
    output numbers: int[3]
    output point: point_t*
    logical action later: int
    logical action again
    @max_pending_events(3)
    logical action three(0, 0, "drop"): int[3]
    state point_: point_t = {= { 7 } =}
    reaction(startup) -> number, nothing, numbers, point, later, again, three {=
        int array[] = { 1, 2, 3 };
        lf_set(number, 4);
        lf_set(nothing);
        lf_set_array(numbers, array);
        lf_set(point, &self->point_);
        validate(lf_schedule(later, MSEC(2), 5) == LF_OK);
        validate(lf_schedule(again, MSEC(3)) == LF_OK);
        validate(lf_schedule_array(three, MSEC(4), array) == LF_OK);
        validate(lf_schedule_array(three, MSEC(4), array) == LF_OK);
        validaten(lf_is_present(later));
    =}
    reaction(later) {= validate(*lf_get(later) == 5 && env->get_elapsed_logical_time(env) == MSEC(2)); =}
    reaction(three) {=
        printf("three %d at %lld\n", three->value[2], (long long)env->get_elapsed_logical_time(env));
        validate(env->get_logical_time(env) - env->scheduler->start_time == MSEC(4));
        validate(env->scheduler->current_tag(env->scheduler).time == env->get_logical_time(env));
        validate(env->get_physical_time(env) > 0 && env->get_elapsed_physical_time(env) > 0);
        validate(env->wait_for(env, MSEC(1)) == LF_OK);
        env->request_shutdown(env, MSEC(1));
    =}
    reaction(shutdown) {= printf("the end at %lld\n", (long long)env->get_elapsed_logical_time(env)); =}
}
reactor Sink(bank_idx: int = 9) {
    input number: int
    input nothing: void
    input numbers: int[3]
    input point: point_t*
    reaction(number, nothing, numbers, point) {=
        validate(lf_is_present(nothing));
        numbers->value[0] += 10;
        printf("%d: %d %d %d %d\n", self->bank_idx, number->value, numbers->value[0], point->value->number,
               number->super.intended_tag.microstep);
        lf_print("%s", lf_time_logical_elapsed() == 0 ? "now" : "later");
    =}
}
@platform("native")
@timeout(1 s)
@fast(false)
@logging("INFO")
main reactor {
    source = new Source()
    sinks = new[2] Sink()
    (source.number)+ -> sinks.number
    (source.nothing)+ -> sinks.nothing
    (source.numbers)+ -> sinks.numbers
    (source.point)+ -> sinks.point
}
"#;

#[test]
fn bodies_have_the_api_of_reactor_uc() {
    let folder = folder(&[("Api.ulf", API)]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder.path()).args(["run", "Api.ulf"]).env("CARGO_NET_OFFLINE", "true");
    let output = said(command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0"));
    let expected = "0: 4 11 7 0\nnow\n1: 4 11 7 0\nnow\nthree 3 at 4000000\nthe end at 5000000\n";
    assert_eq!(text(&output.stdout), expected, "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("warning"), "{}", text(&output.stderr));
}

#[test]
fn a_check_that_fails_names_its_line() {
    let program = "main reactor {\n    reaction(startup) {= validate(1 + 1 == 3); =}\n}\n";
    let folder = folder(&[("Wrong.ulf", program)]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_lfz"));
    command.current_dir(folder.path()).args(["run", "Wrong.ulf"]).env("CARGO_NET_OFFLINE", "true");
    let output = said(command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_INCREMENTAL", "0"));
    assert_eq!(output.status.code(), Some(1));
    let all = text(&output.stdout) + &text(&output.stderr);
    assert!(all.contains("Wrong.ulf:2: not true: 1 + 1 == 3"), "{all}");
}
