// SPDX-License-Identifier: Apache-2.0
//! On what measurements ran, and with what.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::{Deserialize, Serialize};

/// A computer, as Linux tells of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// How many threads it runs at once.
    pub cores: usize,
    /// Memory in GiB.
    pub memory_gib: f64,
    /// The kernel's version.
    pub kernel: String,
    /// How the processor's frequency is chosen, where Linux chooses it.
    pub governor: Option<String>,
    /// The hypervisor below it, if there is one.
    pub virtualized_by: Option<String>,
    /// How many processes wanted to run at the beginning, over the last minute, as in `/proc/loadavg`.
    pub load: f64,
    /// What was measured, and what built it.
    pub versions: Vec<Version>,
}

/// The version of something.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Version {
    /// What it is.
    pub name: String,
    /// In its own words.
    pub version: String,
}

impl Machine {
    /// This computer, with what is in this repository, and the RTI to compare with.
    pub fn this(repository: &Path, stock_rti: Option<&Path>) -> Self {
        let cpuinfo = read("/proc/cpuinfo");
        let field = |name: &str| {
            let line = cpuinfo.lines().find(|line| line.starts_with(name));
            line.and_then(|line| line.split_once(':')).map(|(_, value)| value.trim().to_owned())
        };
        let memory = read("/proc/meminfo");
        let memory = memory.lines().find_map(|line| line.strip_prefix("MemTotal:")?.split_whitespace().next());
        let memory_kib: f64 = memory.and_then(|number| number.parse().ok()).unwrap_or(0.0);
        let hypervisor = said(Command::new("systemd-detect-virt").arg("--vm"));
        Self {
            processor: field("model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            memory_gib: (memory_kib / 1024.0 / 102.4).round() / 10.0,
            kernel: read("/proc/sys/kernel/osrelease").trim().to_owned(),
            governor: fs::read_to_string("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
                .ok()
                .map(|text| text.trim().to_owned()),
            virtualized_by: hypervisor.filter(|name| name != "none").or_else(|| {
                let flags = field("flags")?;
                flags.split(' ').any(|flag| flag == "hypervisor").then(|| "a hypervisor".to_owned())
            }),
            load: read("/proc/loadavg").split(' ').next().and_then(|text| text.parse().ok()).unwrap_or(0.0),
            versions: versions(repository, stock_rti),
        }
    }
}

fn versions(repository: &Path, stock_rti: Option<&Path>) -> Vec<Version> {
    let mut versions = Vec::new();
    let mut add = |name: &str, version: Option<String>| {
        versions.extend(version.map(|version| Version { name: name.to_owned(), version }));
    };
    add("lf-zephyr-rs", commit(repository));
    if let Some(path) = stock_rti {
        let version = path.parent().and_then(commit).unwrap_or_else(|| "version unknown".to_owned());
        add("stock RTI", Some(version));
    }
    add("Rust", said(Command::new("rustc").arg("--version")));
    for program in ["gcc", "arm-none-eabi-gcc", "qemu-system-arm"] {
        add(program, said(Command::new(program).arg("--version")));
    }
    let base = std::env::var_os("ZEPHYR_BASE");
    add("Zephyr", base.and_then(|base| zephyr(Path::new(&base))));
    versions
}

/// The commit of the repository that a folder is in, and whether something was changed since.
fn commit(folder: &Path) -> Option<String> {
    let git = |arguments: &[&str]| said(Command::new("git").arg("-C").arg(folder).args(arguments));
    let commit = git(&["log", "-1", "--format=%h of %cs"])?;
    let is_dirty = git(&["status", "--porcelain", "--untracked-files=no"]).is_some();
    Some(if is_dirty { commit + ", with changes that are not committed" } else { commit })
}

fn zephyr(base: &Path) -> Option<String> {
    let text = fs::read_to_string(base.join("VERSION")).ok()?;
    let number = |key: &str| {
        let line = text.lines().find(|line| line.starts_with(key))?;
        line.split_once('=').map(|(_, value)| value.trim().to_owned())
    };
    Some(format!("{}.{}.{}", number("VERSION_MAJOR")?, number("VERSION_MINOR")?, number("PATCHLEVEL")?))
}

/// The first line that a program says, if it is there and says anything.
pub(crate) fn said(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| text.lines().next().map(|line| line.trim().to_owned())).flatten()
}

fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}
