// SPDX-License-Identifier: Apache-2.0
//! The meanings of the options.

use std::ffi::OsString;

use lf_linux::Credentials;
use lf_linux::model::time::Interval;
use lf_linux::rti::{ClockSync, Options};

use super::super::{Cli, Command, RtiArgs};

fn options(arguments: &[&str]) -> Result<Options, String> {
    let mut warnings = Vec::new();
    let options = parsed(&[&["lfz", "rti"], arguments].concat())?.options(&mut warnings);
    assert!(warnings.is_empty(), "{warnings:?}");
    options
}

fn parsed(words: &[&str]) -> Result<RtiArgs, String> {
    let cli = Cli::read(words.iter().map(OsString::from)).map_err(|error| error.to_string())?;
    let Command::Rti(arguments) = cli.command else { panic!("rti was asked for") };
    Ok(arguments)
}

#[test]
fn the_defaults_are_the_stock_rtis() {
    let options = options(&["-n", "2"]).expect("it is valid");
    assert_eq!(options.federation_id, "Unidentified Federation");
    assert_eq!(options.port, 15045);
    assert_eq!(options.clock_sync, ClockSync::Init { trials: 10 });
    assert!(options.dnet && !options.authentication);
    assert_eq!(options.start_time_multiple, None);
    assert_eq!(options.start_barrier_time_out, Some(Interval::from_secs(60)));
}

#[test]
fn tls_without_verification_needs_a_word_of_its_own_and_has_a_warning() {
    let tls = ["-n", "2", "-tls", "rti.crt", "rti.key"];
    assert!(options(&tls).expect_err("nobody is verified").contains("say --unverified, too"));
    let mut warnings = Vec::new();
    let words = [&["lfz", "rti"], &tls[..], &["--unverified"]].concat();
    let read = parsed(&words).and_then(|arguments| arguments.options(&mut warnings)).expect("it is valid");
    let (certificate, key) = ("rti.crt".into(), "rti.key".into());
    assert_eq!(read.credentials, Credentials::Unverified { certificate, key });
    assert!(warnings[0].contains("anybody can make one"), "{warnings:?}");
    assert_eq!(options(&["-n", "2", "--keys", "k"]).map(|read| read.credentials), Ok(Credentials::Keys("k".into())));
    for words in [&["-n", "2", "--unverified"][..], &["-n", "2", "--keys", "k", "-tls", "c", "k"], &["-n", "2", "-tls"]]
    {
        assert!(options(words).is_err(), "{words:?}");
    }
}

#[test]
fn the_time_for_coming_back_is_a_time_or_off() {
    let of = |text| options(&["-n", "2", "--start-time-out", text]).map(|options| options.start_barrier_time_out);
    assert_eq!(of("off"), Ok(None));
    assert_eq!(of("1500 ms"), Ok(Some(Interval::from_millis(1500))));
    assert!(of("soon").is_err());
}

#[test]
fn the_stock_rtis_options_in_its_order_are_understood() {
    let arguments =
        ["-i", "f", "-n", "3", "-p", "15050", "-c", "init", "exchanges-per-interval", "3", "-m", "7", "s", "-d", "-a"];
    let options = options(&arguments).expect("it is valid");
    assert_eq!(options.federates, 3);
    assert_eq!(options.clock_sync, ClockSync::Init { trials: 3 });
    assert_eq!(options.start_time_multiple, Some(Interval::from_secs(7)));
    assert_eq!(options.transients, 0);
    assert!(!options.dnet && options.authentication);
}

#[test]
fn wrong_values_are_named() {
    for (arguments, name) in [
        (&["-n", "0"][..], "0"),
        (&["-n", "2", "-m", "7", "moons"], "moons"),
        (&["-n", "2", "-c", "maybe"], "maybe"),
        (&["-n", "2", "-i", ""], "at least one character"),
        (&["-i", "-n", "2"], "a value is required for '--id <ID>'"),
        (&["-n", "2", "-m", "-7", "s"], "`-7` is no number"),
        (&["-n", "2", "-nt", "2"], "2 of 2 federates are transient"),
        (&["-n", "2", "-nt", "some"], "some"),
        (&["-n", "2", "-x"], "-x"),
        (&["-n", "2", "stray"], "stray"),
        (&["-p", "15050"], "--number_of_federates"),
    ] {
        let error = options(arguments).expect_err("it is wrong");
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn authentication_with_the_id_that_everybody_knows_is_warned_of() {
    for (arguments, is_warned_of) in [
        (&["-n", "2", "-a"][..], true),
        (&["-n", "2", "-a", "-i", "Unidentified Federation"], true),
        (&["-n", "2", "-a", "-i", "another"], false),
        (&["-n", "2"], false),
    ] {
        let mut warnings = Vec::new();
        let arguments = parsed(&[&["lfz", "rti"], arguments].concat()).expect("it is valid");
        arguments.options(&mut warnings).expect("it is valid");
        let is_found = warnings.iter().any(|warning| warning.contains("-a, --auth") && warning.contains("-i"));
        assert_eq!(is_found, is_warned_of, "{warnings:?}");
    }
}

/// The stock RTI accepts all these cases, too.
#[test]
fn blanks_are_skipped_and_the_last_of_equal_options_counts() {
    let options = options(&[
        " ", "-n", "2", " ", "-i", "one", "-c", "off", " ", "-a", "-a", "-t", "-t", "-d", "-d", "-m", "1", "s", "-p",
        "1", "--id", "another", "-nt", "0", "-p", "15046", "-m", "2", "s", "-n", "5", "-c", "init", " ",
    ])
    .expect("it is valid");
    assert_eq!((options.federates, options.port, options.federation_id.as_str()), (5, 15046, "another"));
    assert_eq!(options.start_time_multiple, Some(Interval::from_secs(2)));
    assert_eq!(options.clock_sync, ClockSync::Init { trials: 10 });
}

#[test]
fn an_id_may_look_like_anything_but_an_option() {
    for id in [" ", "-f00d", "--", "-5"] {
        assert_eq!(options(&["-i", id, "-n", "2"]).map(|options| options.federation_id), Ok(id.to_owned()));
    }
}

#[test]
fn under_the_name_rti_the_program_is_the_rti() {
    for name in ["RTI", "/somewhere/bin/RTI", "./RTI"] {
        let options = parsed(&[name, "-n", "2"]).and_then(|arguments| arguments.options(&mut Vec::new()));
        assert_eq!(options.map(|options| options.federates), Ok(2));
        assert!(parsed(&[name, "-v"]).is_ok_and(|arguments| arguments.version));
        let help = parsed(&[name, "--help"]).expect_err("it is no federation");
        assert!(help.contains("Usage: RTI [OPTIONS]") && help.contains("--number_of_federates"), "{help}");
    }
    assert!(parsed(&["/RTI/lfz", "-n", "2"]).is_err(), "this is `lfz` in a folder");
}
