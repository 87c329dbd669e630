// SPDX-License-Identifier: Apache-2.0
//! `lfz` instead of the stock RTI, called by its name in a script like those that `lfc` generates.

use std::collections::BTreeMap;
use std::fs;
use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use lf_federations::{Finished, Lfz, Run, programs};

/// Below the ports that the system assigns by itself, so that only another listener can interfere.
const PORTS: std::ops::Range<u16> = 20_000..32_000;

/// Returns a port without a listener: a launch script names the RTI's port before the RTI runs.
fn free_port() -> u16 {
    let count = u32::from(PORTS.end - PORTS.start);
    let first = u16::try_from(std::process::id() % count).expect("it is a number of ports");
    let mut ports = (PORTS.start + first..PORTS.end).chain(PORTS);
    ports.find(|port| TcpListener::bind((Ipv4Addr::UNSPECIFIED, *port)).is_ok()).expect("there is a free port")
}

/// Runs the script with these federates, and an RTI in the first folder of the path.
fn launch(federates: &BTreeMap<String, PathBuf>, rti: impl FnOnce(&Path), multiple: &str) -> Finished {
    let folder = tempfile::tempdir().expect("there is a folder for such");
    rti(&folder.path().join("RTI"));
    for (name, program) in federates {
        symlink(program, folder.path().join(name)).expect("the folder is empty");
    }
    let path = std::env::var("PATH").expect("there is a path");
    let mut command = Command::new("bash");
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("launch/launch.sh")).args(federates.keys());
    command.current_dir(folder.path()).env("PATH", format!("{}:{path}", folder.path().display()));
    command.env("RTI_PORT", free_port().to_string()).env("SLEEP_TIME", "0").env("MULTIPLE", multiple);
    Run::start(command).finish()
}

fn assert_well(finished: &Finished) {
    assert_eq!(finished.code(), 0, "{finished}");
    finished.line(&["the federation has ended well"]);
    finished.line(&["Hello World!"]);
}

/// The second time the script has a start time, as with its option `-m`.
#[test]
fn a_launch_script_runs_a_federation_with_lfz_as_its_rti() {
    let federates = Lfz::build("launched", &programs().join("centralized/Greeting.lf"));
    let link = |rti: &Path| symlink(Lfz::path(), rti).expect("the folder is empty");
    assert_well(&launch(&federates, link, ""));
    let copy = |rti: &Path| fs::copy(Lfz::path(), rti).map(drop).expect("there is room for it");
    assert_well(&launch(&federates, copy, "-m 100 ms"));
}
