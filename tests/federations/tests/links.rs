// SPDX-License-Identifier: Apache-2.0
//! Federations whose computers lose their link, in network namespaces that end with the test.

use std::process::Command;

use lf_federations::{Lfz, Run, programs};

/// A network namespace, which exists as long as the process that holds it.
struct Namespace {
    holder: Run,
}

impl Namespace {
    /// Creates a namespace in which this process, and those that enter it, are privileged.
    fn new() -> Self {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--net"]);
        Self::held_by(command)
    }

    /// Creates a second one beside this one.
    fn beside(&self) -> Self {
        let mut command = self.command("unshare");
        command.arg("--net");
        Self::held_by(command)
    }

    fn held_by(mut command: Command) -> Self {
        command.args(["sh", "-c", "ip link set lo up && echo ready && exec tail -f /dev/null"]);
        let mut holder = Run::start(command);
        holder.wait_for("ready");
        Self { holder }
    }

    /// Returns a command that runs in it.
    fn command(&self, program: &str) -> Command {
        let mut command = Command::new("nsenter");
        let process = self.holder.id().to_string();
        command.args(["--preserve-credentials", "--user", "--net", "--target", &process, program]);
        command
    }

    fn ip(&self, words: &str) {
        let mut command = self.command("ip");
        command.args(words.split(' '));
        Run::start(command).succeed();
    }
}

/// With the RTI and the sink on one computer and the source, which always has messages to send, on another one, both
/// notice when the link of the source's computer is down, over either family.
#[test]
fn a_federate_whose_own_link_is_down_notices() {
    let executables = Lfz::build("links", &programs().join("Endless.lf"));
    let here = Namespace::new();
    let there = here.beside();
    here.ip(&format!("link add near type veth peer name far netns {}", there.holder.id()));
    for (side, device, number) in [(&here, "near", 1), (&there, "far", 2)] {
        side.ip(&format!("address add 10.0.0.{number}/24 dev {device}"));
        side.ip(&format!("address add fd00::{number}/64 dev {device} nodad"));
        side.ip(&format!("link set {device} up"));
    }
    let mut runs: Vec<(Run, [Run; 2])> = Vec::new();
    for (id, host) in [("four", "10.0.0.1"), ("six", "[fd00::1]")] {
        let lfz = Lfz::path().to_str().expect("it is a text");
        let mut rti = here.command(lfz);
        rti.args(["rti", "--port", "0", "-n", "2", "-i", id]);
        let mut rti = Run::start(rti);
        let line = rti.wait_for("listening on TCP port");
        let port = line.rsplit(' ').next().expect("the line ends with the port").to_owned();
        let start = |side: &Namespace, name: &str| {
            let mut command = side.command(executables[name].to_str().expect("it is a text"));
            command.args(["--rti", &format!("{host}:{port}"), "--id", id]);
            Run::start(command)
        };
        let (mut source, mut sink) = (start(&there, "source"), start(&here, "sink"));
        source.wait_for("the source runs");
        sink.wait_for("the sink runs");
        runs.push((source, [sink, rti]));
    }
    there.ip("link set far down");
    for (source, others) in runs {
        let source = source.finish();
        assert_eq!(source.code(), 1, "{source}");
        source.line(&["error:", "RTI"]);
        for other in others {
            let other = other.finish();
            assert_eq!(other.code(), 1, "{other}");
        }
    }
}
