// SPDX-License-Identifier: Apache-2.0
//! The command lines with which the launch scripts of `lfc` start the RTI, split into words by a shell.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::process::Command;

use lf_linux::model::time::Interval;
use lf_linux::rti::{ClockSync, Options};

use super::super::{Cli, Command as LfzCommand};
use super::RtiArgs;
use crate::trace::{Table, TableFormat};

/// Runs a part of a launch script with a function instead of the RTI; returns its arguments, its name first.
fn words(script: &str) -> Vec<OsString> {
    let setting = "\
FEDERATION_ID=8f1e
SLEEP_TIME=0
RTI() { printf 'RTI\\0'; printf '%s\\0' \"$@\"; }
ssh() { shift; eval \"$*\"; }
";
    let output = Command::new("bash").arg("-c").arg(format!("{setting}{script}\nwait\n")).output();
    let output = output.expect("bash can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let words = output.stdout.strip_suffix(b"\0").expect("the RTI has been called");
    words.split(|byte| *byte == 0).map(|word| OsString::from_vec(word.to_vec())).collect()
}

fn arguments(script: &str) -> Result<RtiArgs, String> {
    let cli = Cli::read(words(script)).map_err(|error| error.to_string())?;
    let LfzCommand::Rti(arguments) = cli.command else { panic!("the RTI was asked for") };
    Ok(arguments)
}

fn options(script: &str) -> Result<Options, String> {
    let arguments = arguments(script)?;
    let mut warnings = Vec::new();
    let options = arguments.options(&mut warnings);
    assert!(warnings.is_empty(), "{warnings:?}");
    options
}

/// Until 0.5.0, the `&` that ends the command stood on a line of its own.
#[test]
fn the_oldest_scripts() {
    let script = "\
RTI -i ${FEDERATION_ID} \\
                        -n 2 \\
                        -c init \\
exchanges-per-interval 10 \\
&";
    let options = options(script).expect("it is understood");
    assert_eq!((options.federates, options.federation_id.as_str()), (2, "8f1e"));
    assert_eq!(options.clock_sync, ClockSync::Init { trials: 10 });
}

/// From 0.6.0 on, the last word is a blank.
#[test]
fn scripts_that_end_with_a_blank() {
    let options = options(
        "\
RTI -i ${FEDERATION_ID} \\
                        -a \\
                        -d \\
                        -n 3 \\
                        -c on \\
period 5000000 \\
exchanges-per-interval 7 \\ &",
    )
    .expect("it is understood");
    assert_eq!(options.federates, 3);
    assert_eq!(options.clock_sync, ClockSync::On { trials: 7, period: Interval::from_millis(5) });
    assert!(options.authentication && !options.dnet);
}

#[test]
fn scripts_without_clock_synchronization() {
    let script = "\
RTI -i ${FEDERATION_ID} \\
                        -n 2 \\
                        -c off \\ &";
    assert_eq!(options(script).expect("it is understood").clock_sync, ClockSync::Off);
}

/// With `-l`, the output goes into a file.
#[test]
fn scripts_that_keep_the_output() {
    let script = "\
RTI -i ${FEDERATION_ID} \\
                        -n 2 \\
                        -c init \\
exchanges-per-interval 10 \\ >& /dev/stdout &";
    assert_eq!(options(script).expect("it is understood").federates, 2);
}

/// From 0.13.0 on, the start time can be a multiple of a time; 0.14.0 passes the number of transient federates.
#[test]
fn scripts_with_a_start_time_and_transient_federates() {
    for (setting, multiple) in [("", None), ("-m 100 ms", Some(Interval::from_millis(100)))] {
        let script = format!(
            "\
RTI_START_TIME_MULTIPLE=\"{setting}\"
RTI -i ${{FEDERATION_ID}} \\
                        -t \\
                        ${{RTI_START_TIME_MULTIPLE}} \\
                        -n 2 \\
                        -nt 0 \\
                        -c init \\
exchanges-per-interval 10 \\ &"
        );
        let options = options(&script).expect("it is understood");
        assert_eq!(options.start_time_multiple, multiple);
        assert_eq!(options.federates, 2);
        let tables = arguments(&script).expect("it is understood").tables();
        assert_eq!(tables, [Table { file: "rti.lft".into(), format: TableFormat::Lft }]);
    }
}

/// A pane of tmux gets the command in one line, and a blank less.
#[test]
fn scripts_that_use_a_terminal_multiplexer() {
    let script = "RTI -i ${FEDERATION_ID}  -n 2 -nt 0 -c init exchanges-per-interval 10";
    assert_eq!(options(script).expect("it is understood").federates, 2);
}

/// An RTI on another computer is started by a shell there.
#[test]
fn scripts_that_start_a_remote_rti() {
    let script = "\
RTI_START_TIME_MULTIPLE=\"-m 2 sec\"
ssh user@rti.example 'true; \\
    RTI -i '${FEDERATION_ID}' \\
                        '${RTI_START_TIME_MULTIPLE}' \\
                        -n 2 \\
                        -nt 0 \\
                        -c init \\
exchanges-per-interval 10 \\ 2>&1 | tee -a /dev/null' &";
    let options = options(script).expect("it is understood");
    assert_eq!(options.federation_id, "8f1e");
    assert_eq!(options.start_time_multiple, Some(Interval::from_secs(2)));
}

/// The RTI refuses a missing feature with advice.
#[test]
fn scripts_of_programs_with_secured_connections() {
    for (words, why) in [
        ("-tls $HOME/rti.crt $HOME/rti.key", "show no certificates, so that TLS keeps nobody out: say --unverified"),
        ("-sst $HOME/rti.config", "connections that SST secures are not supported; write `security: noise`"),
    ] {
        let script = format!(
            "\
RTI -i ${{FEDERATION_ID}} \\
                        {words} \\
                        -n 2 \\
                        -nt 0 \\
                        -c init \\
exchanges-per-interval 10 \\ &"
        );
        let error = options(&script).expect_err("it is refused");
        assert!(error.contains(why), "{error}");
        let double_dash = options(&script.replace(" -tls", " --tls").replace(" -sst", " --sst"));
        assert_eq!(double_dash.expect_err("it is refused"), error);
    }
}
