// SPDX-License-Identifier: Apache-2.0
//! The supervisor with real processes. Those that "never end" wait for the end of a file that does not end.

use std::io::{self, Write};
use std::os::unix::net::UnixStream;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use super::{Ending, Interrupts, Limits, Output, Role, Streams, Supervisor};

/// Far longer than any test takes.
const LONG: Duration = Duration::from_secs(600);
const FOREVER: &str = "exec tail -f /dev/null";

#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().expect("no writer panics").clone()).expect("the tests write UTF-8")
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("no writer panics").extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A supervisor, its output, and the stream that interrupts it.
struct Bench {
    supervisor: Supervisor,
    standard: Shared,
    error: Shared,
    interrupt: UnixStream,
}

impl Bench {
    fn new(limits: Limits) -> Self {
        let (standard, error) = (Shared::default(), Shared::default());
        let output = Output::new(
            Box::new(standard.clone()),
            Box::new(error.clone()),
            (false, false),
            Some("lfz"),
            ["a", "long"],
        );
        let (interrupt, stream) = UnixStream::pair().expect("a socket pair");
        let supervisor = Supervisor::new(limits, Interrupts::of_stream(2, stream), output);
        Self { supervisor, standard, error, interrupt }
    }

    fn start(&mut self, name: &str, script: &str) {
        self.start_as(name, Role::Federate, script);
    }

    fn start_as(&mut self, name: &str, role: Role, script: &str) {
        let mut shell = Command::new("sh");
        self.supervisor.start(name, role, None, Streams::Lines, shell.args(["-c", script])).expect("sh starts");
    }

    /// Starts a simulator whose program's status is in a line of output.
    fn simulate(&mut self, name: &str, script: &str) {
        let mut shell = Command::new("sh");
        let command = shell.args(["-c", script]);
        let started = self.supervisor.start(name, Role::Federate, Some("status "), Streams::Lines, command);
        started.expect("sh starts");
    }

    fn line(&mut self) -> String {
        self.supervisor.wait_for_line(|line| Some(line.to_owned())).expect("no error").expect("a line comes")
    }
}

fn limits() -> Limits {
    Limits { run: None, grace: LONG, terminate: LONG }
}

#[test]
fn all_end_well_and_each_line_bears_its_name() {
    let mut bench = Bench::new(limits());
    bench.start("a", "echo one; echo two >&2; printf three");
    bench.start("long", "printf 'four\\nfive\\r\\n'");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    let standard = bench.standard.text();
    let mut lines: Vec<&str> = standard.lines().collect();
    lines.sort_unstable();
    assert_eq!(lines, ["a    | one", "a    | three", "long | five", "long | four"]);
    assert_eq!(bench.error.text(), "a    | two\n");
}

#[test]
fn much_output_of_a_process_that_ends_at_once_is_complete() {
    let mut bench = Bench::new(limits());
    bench.start("a", "seq 1 5000");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    assert_eq!(bench.standard.text().lines().count(), 5000);
}

#[test]
fn the_first_failure_ends_the_others_and_decides_the_exit_status() {
    let mut bench = Bench::new(Limits { grace: Duration::ZERO, ..limits() });
    bench.start("a", FOREVER);
    bench.start("long", "exit 3");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(3));
    assert!(bench.error.text().contains("lfz  | long ended with exit status 3"), "{}", bench.error.text());
}

#[test]
fn others_may_end_by_themselves_after_a_failure() {
    let mut bench = Bench::new(limits());
    bench.start("a", "kill -9 $$");
    bench.start("long", "echo last words");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(137));
    assert_eq!(bench.standard.text(), "long | last words\n");
    assert!(bench.error.text().contains("a was ended by signal 9 (SIGKILL)"), "{}", bench.error.text());
}

#[test]
fn a_process_that_ignores_the_request_to_stop_is_killed() {
    let mut bench = Bench::new(Limits { terminate: Duration::ZERO, ..limits() });
    bench.start("a", "trap '' TERM; echo ready; while :; do tail -f /dev/null; done");
    assert_eq!(bench.line(), "ready");
    bench.interrupt.write_all(b"x").expect("the supervisor listens");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Interrupted(2));
    assert!(bench.error.text().contains("killing a, which did not stop when asked to"), "{}", bench.error.text());
}

#[test]
fn an_interrupt_leaves_no_descendant_behind() {
    let mut bench = Bench::new(limits());
    bench.start("a", "tail -f /dev/null & echo $!; trap 'exit 0' TERM; wait");
    let descendant: i32 = bench.line().parse().expect("a process id");
    let descendant = Pid::from_raw(descendant).expect("ids are positive");
    let end = pidfd_open(descendant, PidfdFlags::empty()).expect("it runs");
    bench.interrupt.write_all(b"x").expect("the supervisor listens");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Interrupted(2));
    let mut descriptors = [PollFd::new(&end, PollFlags::IN)];
    assert_eq!(poll(&mut descriptors, None).expect("it can be waited for"), 1);
}

#[test]
fn a_program_that_succeeds_on_being_stopped_does_not_hide_the_interrupt() {
    let mut bench = Bench::new(limits());
    bench.start("a", "trap 'exit 0' TERM; echo ready; tail -f /dev/null & wait");
    assert_eq!(bench.line(), "ready");
    bench.interrupt.write_all(b"x").expect("the supervisor listens");
    assert_eq!(bench.supervisor.finish().expect("no error").exit_code(), 130);
}

#[test]
fn the_time_limit_ends_the_run() {
    let mut bench = Bench::new(Limits { run: Some(Duration::ZERO), ..limits() });
    bench.start("a", FOREVER);
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::TimedOut);
}

#[test]
fn an_rti_that_stays_after_its_federates_is_stopped_and_is_a_failure() {
    let mut bench = Bench::new(Limits { grace: Duration::ZERO, ..limits() });
    bench.start_as("RTI", Role::Rti, FOREVER);
    bench.start("a", "exit 0");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(1));
    assert_eq!(bench.error.text(), "lfz  | RTI did not end with the federation; stopping\n");
}

#[test]
fn a_federate_that_stays_after_the_rti_is_stopped_and_is_a_failure() {
    let mut bench = Bench::new(Limits { grace: Duration::ZERO, ..limits() });
    bench.start_as("RTI", Role::Rti, "exit 0");
    bench.start("a", FOREVER);
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(1));
}

#[test]
fn a_second_interrupt_does_not_wait() {
    let mut bench = Bench::new(limits());
    bench.start("a", "trap '' TERM; echo ready; while :; do tail -f /dev/null; done");
    assert_eq!(bench.line(), "ready");
    bench.interrupt.write_all(b"x").expect("the supervisor listens");
    while !bench.supervisor.plan.is_stopping() {
        bench.supervisor.turn(&mut |_, _| false).expect("no error");
    }
    bench.interrupt.write_all(b"x").expect("the supervisor listens");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Interrupted(2));
    assert_eq!(bench.error.text(), "lfz  | interrupted; stopping all participants\n");
}

#[test]
fn a_simulator_counts_as_ended_with_the_program_in_it_and_stays_until_all_have_ended() {
    let mut bench = Bench::new(limits());
    bench.simulate("long", &format!("echo $$; echo status 0; {FOREVER}"));
    let simulator = Pid::from_raw(bench.line().parse().expect("a process id")).expect("ids are positive");
    let end = pidfd_open(simulator, PidfdFlags::empty()).expect("it runs");
    // It continues, so that no other process ends before it.
    bench.start("a", &format!("kill -0 {} && echo it is there", simulator.as_raw_nonzero()));
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    assert!(bench.standard.text().contains("long | status 0\n"), "{}", bench.standard.text());
    assert!(bench.standard.text().contains("a    | it is there\n"), "{}", bench.standard.text());
    let mut descriptors = [PollFd::new(&end, PollFlags::IN)];
    assert_eq!(poll(&mut descriptors, None).expect("it can be waited for"), 1);
}

#[test]
fn a_simulator_fails_with_the_program_in_it_or_when_it_ends_by_itself() {
    for (script, status, how) in [
        (format!("printf 'status 102\\r\\n'; {FOREVER}"), 102, "long ended with exit status 102"),
        ("echo hello".to_owned(), 1, "long ended before the program in it"),
        ("echo status 7; exit 0".to_owned(), 7, "long ended with exit status 7"),
    ] {
        let mut bench = Bench::new(limits());
        bench.simulate("long", &script);
        assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(status));
        assert_eq!(bench.error.text(), format!("lfz  | {how}\n"));
    }
}

#[test]
fn a_line_without_an_end_does_not_pile_up() {
    let mut bench = Bench::new(limits());
    bench.start("a", "yes | head -c 1000000 | tr -d '\\n'");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    let text = bench.standard.text();
    assert!(text.lines().count() > 1);
    assert_eq!(text.matches('y').count(), 500_000);
}

#[test]
fn a_wanted_line_is_returned_and_not_shown() {
    let mut bench = Bench::new(limits());
    // Boards end their lines like this.
    bench.start("a", "echo first; printf 'port 7\\r\\n'; echo last");
    let port = bench.supervisor.wait_for_line(|line| line.strip_prefix("port ").map(str::to_owned));
    assert_eq!(port.expect("no error").as_deref(), Some("7"));
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    assert_eq!(bench.standard.text(), "a    | first\na    | last\n");
}

#[test]
fn a_wanted_line_that_cannot_come_any_more_is_not_waited_for() {
    let mut bench = Bench::new(limits());
    bench.start("a", "exit 1");
    let line = bench.supervisor.wait_for_line(|_| Some(()));
    assert_eq!(line.expect("no error"), None);
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Failed(1));
}

/// Returns the outcome of a run whose standard output fails in this way, and its messages.
fn with_failing_output(error: fn() -> io::Error) -> (Ending, String) {
    struct Failing(fn() -> io::Error);
    impl Write for Failing {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let (said, (_interrupt, stream)) = (Shared::default(), UnixStream::pair().expect("a socket pair"));
    let (output, said) = (Box::new(Failing(error)), (said.clone(), said));
    let output = Output::new(output, Box::new(said.0), (false, false), Some("lfz"), ["a"]);
    let mut supervisor = Supervisor::new(limits(), Interrupts::of_stream(2, stream), output);
    let (script, mut shell) = (format!("echo x; {FOREVER}"), Command::new("sh"));
    let command = shell.args(["-c", &script]);
    supervisor.start("a", Role::Federate, None, Streams::Lines, command).expect("sh starts");
    (supervisor.finish().expect("no error"), said.1.text())
}

#[test]
fn a_closed_output_ends_the_run_without_a_word() {
    let (ending, said) = with_failing_output(|| io::ErrorKind::BrokenPipe.into());
    assert_eq!((ending, said.as_str()), (Ending::OutputClosed, ""));
}

#[test]
fn an_output_without_room_ends_the_run_and_is_a_failure_that_is_told() {
    let (ending, said) = with_failing_output(|| io::ErrorKind::StorageFull.into());
    assert_eq!(ending, Ending::Failed(1));
    assert_eq!(said, "lfz | the output cannot be written: no storage space; stopping all participants\n");
}

#[test]
fn a_process_with_streams_of_its_own_shows_what_ends_no_line_before_it_goes_on() {
    let mut bench = Bench::new(limits());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fifo = folder.path().join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("it can be run").success());
    let (script, mut shell) = ("printf 'name? '; read -r name < $0; echo hello $name", Command::new("sh"));
    let command = shell.args(["-c", script]).arg(&fifo);
    bench.supervisor.start("a", Role::Federate, None, Streams::Own, command).expect("sh starts");
    while bench.standard.text().is_empty() {
        bench.supervisor.turn(&mut |_, _| false).expect("no error");
    }
    assert_eq!(bench.standard.text(), "name? ");
    std::fs::write(&fifo, "you\n").expect("the shell reads");
    assert_eq!(bench.supervisor.finish().expect("no error"), Ending::Success);
    assert_eq!(bench.standard.text(), "name? hello you\n");
}
