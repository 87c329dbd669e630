// SPDX-License-Identifier: Apache-2.0
//! A thread and a signal each end a wait that nothing else would end. In one test, because signals are the process's.

use lf_coordination::Deadline;
use lf_linux::Linux;
use lf_runtime::platform::Platform as _;
use signal_hook::consts::SIGTERM;

#[test]
fn threads_and_signals_end_a_wait() {
    let mut host = Linux::new().expect("a platform");
    assert!(!host.interrupted());

    // A wake-up that comes before the wait is not lost.
    host.outside().wake();
    host.wait(Deadline::Never, &mut |_, _| panic!("there are no sockets"));

    // As little as one that comes from another thread, whenever it comes.
    let outside = host.outside();
    let thread = std::thread::spawn(move || outside.wake());
    host.wait(Deadline::Never, &mut |_, _| panic!("there are no sockets"));
    thread.join().expect("it does not panic");

    // Many wake-ups end one wait, and a time in the past ends the next.
    for _ in 0..100_000 {
        host.outside().wake();
    }
    host.wait(Deadline::Never, &mut |_, _| panic!("there are no sockets"));
    let before = host.now();
    host.wait(Deadline::At(before), &mut |_, _| panic!("there are no sockets"));
    host.wait(Deadline::Now, &mut |_, _| panic!("there are no sockets"));

    assert!(!host.interrupted());
    signal_hook::low_level::raise(SIGTERM).expect("a signal can be raised");
    host.wait(Deadline::Never, &mut |_, _| panic!("there are no sockets"));
    assert!(host.interrupted());
}
