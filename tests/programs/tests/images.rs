// SPDX-License-Identifier: Apache-2.0
//! Images in virtual time: an RTI and federates in static memory.
#![allow(clippy::unwrap_used, reason = "a failed unwrap in a helper is that test's failure")]

use std::sync::Mutex;
use std::thread;

use lf_embedded::federate::{MinBuffers, Sizes};
use lf_embedded::rti::{self, ClockSync, ImageRti};
use lf_linux::model::Interval;
use lf_programs::alone::Alone::federate as alone;
use lf_programs::images::receiver::federate as receiver;
use lf_programs::images::receiver::images::RECEIVED;
use lf_programs::images::sender::federate as sender;
use lf_runtime::platform::{Endpoint, Platform};
use lf_runtime::trace::Recording;
use lf_runtime::{Description, ImageError, Join, RtiError, SettingsError};
use lf_testkit::network::address_of;
use lf_testkit::world::{Conditions, Threads, Virtual};

use log::LevelFilter;

/// The bytes of a value on the connection.
const VALUE_BYTES: usize = 800;
/// The federation as the RTI knows it.
static RTI: rti::Description = rti::Description {
    federation_id: "Images",
    authentication: None,
    clock_sync: ClockSync::On { trials: 3, period: Interval::from_millis(5) },
    dnet: true,
    log_waits: None,
    logging: LevelFilter::Info,
    payload_bytes_max: VALUE_BYTES,
};
/// The RTI's number among the participants.
const RTI_NUMBER: usize = 0;
const PORT: u16 = 15045;
/// The system's minimum: more than the sender needs, and less than the receiver does.
const LEAST: MinBuffers = MinBuffers { input_bytes: 600, output_bytes: 1 };

type RtiMemory = rti::Memory<Virtual, rti::Parts<2, 0, 3, 1, 4, { RTI.buffer_bytes(2, 64) }>>;

/// The settings of an image: no other federation id than the program's.
const JOIN: fn() -> Result<Join<'static>, SettingsError> =
    || Ok(Join { federation_id: b"", rti: Endpoint::new(address_of(RTI_NUMBER), PORT), others: &[] });

/// Returns a world with one participant, whose turn it is.
fn one_participant() -> (Threads, Virtual) {
    let world = Threads::new(Conditions::seeded(7));
    let mut platform = world.join(Interval::ZERO, Interval::ZERO);
    world.start();
    platform.begin();
    (world, platform)
}

fn run_sender(platform: &mut impl Platform) -> Result<(), ImageError> {
    lf_embedded::run!(sender::SenderFederate, platform, Recording::OFF, JOIN, LEAST)
}

fn run_receiver(platform: &mut impl Platform) -> Result<(), ImageError> {
    lf_embedded::run!(receiver::ReceiverFederate, platform, Recording::OFF, JOIN, LEAST)
}

fn run_alone(platform: &mut impl Platform) -> Result<(), ImageError> {
    lf_embedded::run!(alone::AloneMain, platform, Recording::OFF, || unreachable!("it joins nothing"), LEAST)
}

#[test]
fn a_federation_runs_from_start_to_end_in_static_memory() {
    static MEMORY: RtiMemory = RtiMemory::new();
    let world = Threads::new(Conditions::seeded(3));
    let [mut rti, mut one, mut other] = [0, 1, 2].map(|_| world.join(Interval::ZERO, Interval::ZERO));
    let outcomes = Mutex::new(Vec::new());
    thread::scope(|scope| {
        let (outcomes, at_rti) = (&outcomes, &world);
        scope.spawn(move || {
            rti.begin();
            let image: &dyn ImageRti<Virtual> = &MEMORY;
            assert_eq!(MEMORY.listen(&RTI, rti, PORT, b"").unwrap(), PORT);
            let outcome = image.run(&RTI, Recording::OFF);
            // The memory keeps the platform, so it is never dropped.
            at_rti.leave(RTI_NUMBER);
            outcomes.lock().unwrap().push(format!("{outcome:?}"));
        });
        scope.spawn(move || {
            one.begin();
            let outcome = run_sender(&mut one);
            outcomes.lock().unwrap().push(format!("{outcome:?}"));
            assert!(matches!(run_sender(&mut one), Err(ImageError::Running)), "its memory is in use");
        });
        scope.spawn(move || {
            other.begin();
            let outcome = run_receiver(&mut other);
            outcomes.lock().unwrap().push(format!("{outcome:?}"));
        });
        world.start();
    });
    assert_eq!((world.violation(), outcomes.into_inner().unwrap()), (None, vec!["Ok(())".to_owned(); 3]));
    assert_eq!(*RECEIVED.lock().unwrap(), [1, 2, 3, 4, 5]);
}

#[test]
fn a_program_that_is_not_federated_asks_for_no_federation() {
    let (world, mut platform) = one_participant();
    assert!(matches!(run_alone(&mut platform), Ok(())));
    assert_eq!(world.now(), Interval::from_millis(30), "it ends with its time-out");
}

#[test]
fn a_setting_that_is_of_no_use_ends_the_program() {
    let (_world, mut platform) = one_participant();
    let join = || Err(SettingsError::RtiPort(70_000));
    let outcome = lf_embedded::run!(sender::SenderFederate, &mut platform, Recording::OFF, join, LEAST);
    assert!(matches!(outcome, Err(ImageError::Settings(SettingsError::RtiPort(70_000)))), "{outcome:?}");
}

#[test]
fn an_rti_that_is_run_in_another_order_says_so() {
    static MEMORY: RtiMemory = RtiMemory::new();
    let (world, platform) = one_participant();
    assert!(matches!(MEMORY.run(&RTI, Recording::OFF), Err(RtiError::Order)), "it does not listen yet");
    assert_ne!(MEMORY.listen(&RTI, platform, 0, b"another").unwrap(), 0, "the system chooses a port");
    let second = MEMORY.listen(&RTI, world.join(Interval::ZERO, Interval::ZERO), PORT, b"");
    assert!(matches!(second, Err(RtiError::Order)), "{second:?}");
}

#[test]
fn a_port_that_cannot_be_listened_on_is_named() {
    static MEMORY: RtiMemory = RtiMemory::new();
    let (world, platform) = one_participant();
    world.leave(RTI_NUMBER);
    let outcome = MEMORY.listen(&RTI, platform, PORT, b"");
    assert!(matches!(outcome, Err(RtiError::Listen { port: PORT, .. })), "{outcome:?}");
    assert!(matches!(MEMORY.run(&RTI, Recording::OFF), Err(RtiError::Order)), "it listens nowhere");
}

#[test]
fn buffers_are_as_large_as_the_program_and_the_system_ask_for() {
    let sizes = |description: &Description| {
        let Sizes { input_bytes, output_bytes, peers_in, peers_out, .. } = Sizes::of(description, LEAST);
        (input_bytes, output_bytes, peers_in, peers_out)
    };
    let federation = receiver::DESCRIPTION.federation.unwrap();
    assert!(federation.input_bytes > LEAST.input_bytes && federation.output_bytes > LEAST.output_bytes);
    assert_eq!(sizes(&receiver::DESCRIPTION), (federation.input_bytes, federation.output_bytes, 0, 0));
    let federation = sender::DESCRIPTION.federation.unwrap();
    assert_eq!(sizes(&sender::DESCRIPTION), (LEAST.input_bytes, federation.output_bytes, 0, 0));
    assert_eq!(Sizes::of(&alone::DESCRIPTION, LEAST), Sizes::default());
    // 17 bytes precede a payload of 4 bytes, which is shorter than what the system asks for.
    assert_eq!((RTI.buffer_bytes(2, 4096), rti::longest(&[3, 9, 4]), rti::longest(&[])), (4096, 9, 0));
}
