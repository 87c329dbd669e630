// SPDX-License-Identifier: Apache-2.0
//! Reactions in C run at the same time, and what they do is as if they had run one after the other.

use crate::support::{folder, lfz, said, text};

/// No reaction of the first level ends before all four have begun; each uses what is its own thread's.
const PROGRAM: &str = r#"
target C { workers: 4, fast: true }
preamble {=
    #include <pthread.h>
    #include <stdio.h>
    /* Each reactor's file has the preamble, and all of them mean the same variables. */
    #define SHARED __attribute__((weak))
    SHARED pthread_barrier_t meeting;
    SHARED pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    SHARED pthread_t threads[4];
    SHARED int met = 0;
    static void meet(void) {
        pthread_barrier_wait(&meeting);
        pthread_mutex_lock(&lock);
        for (int i = 0; i < met; i++) {
            LF_TEST(!pthread_equal(threads[i], pthread_self()), "a thread of its own");
        }
        threads[met++] = pthread_self();
        pthread_mutex_unlock(&lock);
        pthread_barrier_wait(&meeting);
    }
=}
reactor Member(bank_index: int = 0, first: int = 1) {
    input numbers: int[]
    output sum: int
    logical action again: int
    physical action outside
    state of_action: int = 0

    reaction(numbers) -> sum, again, outside {=
        meet();
        LF_TEST(NUMBER_OF_WORKERS == 4, "workers");
        LF_TEST(lf_time_logical_elapsed() == MSEC(1), "the tag is known");
        int total = 0;
        for (size_t i = 0; i < numbers->length; i++) {
            total += numbers->value[i];
        }
        lf_set(sum, total * (self->bank_index + 1));
        if (self->bank_index == 0) {
            lf_schedule_int(again, 0, 7);
        } else if (self->bank_index == 2) {
            lf_schedule(outside, MSEC(1));
        }
    =}

    reaction(again) {=
        printf("again %d in %d at microstep %u\n", again->value, self->bank_index, lf_tag().microstep);
    =}
    reaction(outside) {=
        printf("outside in %d\n", self->bank_index);
        lf_request_stop();
    =}
}
reactor Changing {
    mutable input numbers: int[]
    output out: int
    reaction(numbers) -> out {=
        numbers->value[0] = 1000;
        meet();
        lf_set(out, numbers->value[0] + numbers->value[1]);
    =}
}
reactor Source {
    timer t(1 ms)
    output numbers: int[]
    reaction(startup) {= pthread_barrier_init(&meeting, NULL, 4); =}
    reaction(t) -> numbers {=
        int *values = (int *)malloc(2 * sizeof(int));
        values[0] = 20;
        values[1] = 1;
        lf_set_array(numbers, values, 2);
    =}
}
reactor Sink {
    input[4] x: int
    reaction(x) {=
        for (int i = 0; i < 4; i++) {
            printf("%d ", x[i]->value);
        }
        printf("are the sums\n");
    =}
}
main reactor {
    source = new Source()
    members = new[3] Member()
    changing = new Changing()
    sink = new Sink()
    (source.numbers)+ -> members.numbers, changing.numbers
    members.sum, changing.out -> sink.x
}
"#;

#[test]
fn reactions_in_c_run_in_as_many_threads_as_there_are_workers() {
    let folder = folder(&[("P.lf", PROGRAM)]);
    let output = said(&mut lfz(folder.path(), &["run"]));
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
    let expected = "21 42 63 1001 are the sums\nagain 7 in 0 at microstep 1\noutside in 2\n";
    assert_eq!(text(&output.stdout), expected);
}
