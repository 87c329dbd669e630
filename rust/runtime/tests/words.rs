// SPDX-License-Identifier: Apache-2.0
//! The sentences of errors and log events: each differs from all others, and its code leads to it.
use std::collections::BTreeSet;
use std::fmt::Display;
use std::time::Duration;

use lf_coordination::rti::Outcome;
use lf_model::EventTag;
use lf_runtime::platform::{NetError, RandomError};
use lf_runtime::trace::Damage;
use lf_runtime::{
    CODE_PREFIX, Code, ConnectionEvent, DeviceEvent, ImageError, LogEvent, PeerEvent, PeerFault, RtiError, RunError,
    SettingsError, explain,
};

fn sentences<const N: usize>(all: [&dyn Display; N]) -> [String; N] {
    let all = all.map(ToString::to_string);
    assert_eq!(BTreeSet::from(all.clone()).len(), N, "{all:?}");
    assert!(all.iter().all(|sentence| sentence.len() > 5), "{all:?}");
    all
}

/// Asserts that the code of an event leads to its sentence.
fn is_explained<T: LogEvent + Display>(said: &T) {
    let (code, mut found) = (Code::of(said).to_string(), None);
    assert!(code.starts_with(CODE_PREFIX), "{code}");
    assert!(explain(&code, |text| text.to_owned().leak(), &mut |said| found = Some(said.to_string())), "{code}");
    assert_eq!(found, Some(said.to_string()));
}

#[test]
fn errors_of_the_network_differ_and_carry_the_systems_number() {
    use NetError::{AddressInUse, NoSocketLeft, Os, Refused, Reset, Stale, Unreachable};
    let all = sentences([&AddressInUse, &NoSocketLeft, &Refused, &Reset, &Stale, &Unreachable, &Os(71)]);
    assert!(all[6].contains("71"));
    assert!(sentences([&RandomError(-72)])[0].contains("-72"));
}

#[test]
fn errors_of_an_image_contain_what_they_are_made_of() {
    let settings = [SettingsError::RtiAddress, SettingsError::RtiPort(70_000)];
    let [address, port] = sentences([&settings[0], &settings[1]]);
    assert!(address.contains("CONFIG_LF_RTI_ADDRESS") && port.contains("70000"));
    let image = [
        ImageError::Descriptor,
        ImageError::Settings(settings[1]),
        ImageError::Run(RunError::Interrupted),
        ImageError::Running,
    ];
    let [_, with_settings, with_run, _] = sentences(image.each_ref().map(|error| error as &dyn Display));
    assert_eq!((with_settings, with_run), (port.clone(), RunError::Interrupted.to_string()));
    let rti = [
        RtiError::Settings(settings[0]),
        RtiError::Listen { port: 15_045, error: NetError::AddressInUse },
        RtiError::Bind(NetError::NoSocketLeft),
        RtiError::Ended(Outcome::Aborted),
        RtiError::Order,
    ];
    let [of_settings, listen, bind, ended, _] = sentences(rti.each_ref().map(|error| error as &dyn Display));
    assert_eq!((of_settings, ended), (address, Outcome::Aborted.to_string()));
    assert!(listen.contains("15045") && listen.contains(&NetError::AddressInUse.to_string()));
    assert!(bind.contains(&NetError::NoSocketLeft.to_string()));
    image.iter().for_each(is_explained);
    rti.iter().for_each(is_explained);
}

#[test]
fn log_events_differ_and_their_codes_lead_to_them() {
    let refused = ConnectionEvent::NoRandom(RandomError(-5));
    let device = DeviceEvent::EventsLost { device: "button", events: 71 };
    let peers = [PeerEvent::Left(71), PeerEvent::DoesNotEnd(72), PeerEvent::LeftInMessage(73)];
    let all = sentences([&refused, &device, &peers[0], &peers[1], &peers[2]]);
    for (sentence, number) in
        all.iter().zip(["-5", "button that its action's queue had no room for: 71", "71", "72", "73"])
    {
        assert!(sentence.contains(number), "{sentence}");
    }
    is_explained(&refused);
    is_explained(&device);
    peers.iter().for_each(is_explained);
}

#[cfg(feature = "peers")]
#[test]
fn faults_of_another_federate_differ() {
    use PeerFault::{Blocked, Unanswered, WrongInput};
    let tag = |nanos| EventTag::new(Duration::from_nanos(nanos), 3);
    let late = RunError::Late { input: "a.in", tag: tag(71), current: tag(72) };
    let [_, _, wrong, late] = sentences([&Blocked, &Unanswered, &WrongInput { federate: 71, port: 72 }, &late]);
    assert!(wrong.contains("71") && wrong.contains("72"), "{wrong}");
    assert!(
        late.contains("a.in") && late.contains(&tag(71).to_string()) && late.contains(&tag(72).to_string()),
        "{late}"
    );
}

#[test]
fn damage_names_the_version_or_the_kind() {
    let [_, version, kind] = sentences([&Damage::Foreign, &Damage::Version(71), &Damage::Kind(72)]);
    assert!(version.contains("71") && kind.contains("72"));
}
