// SPDX-License-Identifier: Apache-2.0
//! The supported target properties, and those that are refused.
#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "a method of a type with a lifetime is no function for every lifetime"
)]

use super::reader::{Read, TargetReader};
use crate::lexical::Language;
use crate::plan;
use crate::syntax::ast::{Name, PropertyValue};

/// A supported target property, with its documentation and its reader.
#[derive(Clone, Copy, Debug)]
pub struct TargetProperty {
    /// Its name.
    pub name: &'static str,
    /// Its values, as they are written in a program.
    pub values: &'static [&'static str],
    /// Its effect, in Markdown.
    pub does: &'static str,
    /// The programs that have it.
    pub scope: PropertyScope,
    pub(super) imported: Imported,
    /// Whether it is read after all others.
    pub(super) is_late: bool,
    pub(super) read: Read,
}

/// The programs that have a target property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyScope {
    /// Federations: it configures the coordination.
    Coordination,
    /// All programs.
    Program,
    /// Programs with bodies in a language.
    Bodies(Language),
}

/// The effect of a target property in an imported file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Imported {
    Never,
    /// It has an effect in a file whose language is not that of the main file.
    OfOtherLanguage,
    Always,
}

const fn property(
    scope: PropertyScope,
    name: &'static str,
    values: &'static [&'static str],
    does: &'static str,
    read: Read,
) -> TargetProperty {
    TargetProperty { name, values, does, scope, imported: Imported::Never, is_late: false, read }
}

impl TargetProperty {
    const fn imported(self, imported: Imported) -> Self {
        Self { imported, ..self }
    }

    const fn late(self) -> Self {
        Self { is_late: true, ..self }
    }

    /// Returns whether programs with bodies in a language have it.
    pub(super) fn is_of(&self, language: Language) -> bool {
        match self.scope {
            PropertyScope::Coordination | PropertyScope::Program => true,
            PropertyScope::Bodies(own) => own == language,
        }
    }
}

/// Returns the property of a name in programs with bodies in a language.
pub(super) fn named(name: &str, language: Language) -> Option<&'static TargetProperty> {
    honoured(language).find(|property| property.name == name)
}

/// Returns whether only federations have the property of a name, in any case of letters.
pub(crate) fn is_of_federations(name: &str) -> bool {
    let mut own = PROPERTIES.iter().filter(|property| property.scope == PropertyScope::Coordination);
    own.any(|property| property.name.eq_ignore_ascii_case(name))
}

/// Returns all properties that programs with bodies in a language have.
pub(super) fn honoured(language: Language) -> impl Iterator<Item = &'static TargetProperty> + Clone {
    PROPERTIES.iter().filter(move |property| property.is_of(language))
}

/// Reads a property that other compilers need, and that has no effect by itself in this one.
fn switch(reader: &mut TargetReader<'_>, key: &Name, value: &PropertyValue) {
    reader.boolean(key, value);
}

/// The maximum number of threads of a program.
const WORKERS_MAX: u64 = 1024;

const SWITCH: &[&str] = &["true", "false"];

const CMAKE_INCLUDE: &str = "a file for CMake, which configures images and programs for this computer by it; \
                             `${LF_MAIN_TARGET}` is the program";

/// All supported target properties. Those of a scope are in the order for readers.
pub(super) const PROPERTIES: &[TargetProperty] = &[
    property(
        PropertyScope::Coordination,
        "coordination",
        &["centralized", "decentralized"],
        "the decision when a tag begins: by the RTI, or by each federate when its waits are over",
        |reader, key, value| {
            if reader.word(key, value, &["centralized", "decentralized"]) == Some("decentralized") {
                reader.target.coordination = plan::Coordination::Decentralized;
            }
        },
    ),
    property(
        PropertyScope::Coordination,
        "coordination-options",
        &["{ log-waits: 500 ms }", "{ advance-message-interval: 10 ms }"],
        "the wait after which a participant logs its reason; the interval in which a federate with physical actions \
         announces its progress",
        |reader, key, value| reader.coordination_options(key, value),
    ),
    property(
        PropertyScope::Coordination,
        "DNET",
        SWITCH,
        "whether the RTI may tell federates which announcements no participant needs",
        |reader, key, value| reader.target.dnet = reader.boolean(key, value).unwrap_or(true),
    ),
    property(
        PropertyScope::Coordination,
        "clock-sync",
        &["off", "init", "on"],
        "when clocks are compared with the RTI's: never, before the start, all the time",
        |reader, key, value| match reader.word(key, value, &["off", "init", "on"]) {
            Some("off") => reader.target.clock_sync = plan::ClockSync::Off,
            Some("init") => reader.target.clock_sync = plan::ClockSync::Init,
            Some("on") => reader.target.clock_sync = plan::ClockSync::On,
            _ => {}
        },
    ),
    property(
        PropertyScope::Coordination,
        "clock-sync-options",
        &[
            "{ trials: 10 }",
            "{ period: 5 ms }",
            "{ attenuation: 10 }",
            "{ local-federates-on: true }",
            "{ test-offset: 1 ms }",
            "{ collect-stats: true }",
        ],
        "the frequency of the comparisons, and the use of their results",
        |reader, key, value| reader.clock_sync_options(key, value),
    ),
    property(
        PropertyScope::Coordination,
        "auth",
        SWITCH,
        "whether the RTI and the federates prove to each other that they know the federation id",
        |reader, key, value| reader.target.authentication = reader.boolean(key, value).unwrap_or_default(),
    ),
    property(
        PropertyScope::Coordination,
        "comm-type",
        &["TCP", "TLS"],
        "the connections of federates on Linux: TCP, or TLS over TCP, see [security](security.md)",
        |reader, key, value| reader.comm_type(key, value),
    ),
    property(
        PropertyScope::Coordination,
        "security",
        &["none", "noise"],
        "the encryption of all connections: none, or Noise with a key for each participant; with `comm-type: TLS` also \
         `unverified`, by which nobody proves who it is, as with LF; see [security](security.md)",
        |reader, key, value| reader.security(key, value),
    )
    .late(),
    property(
        PropertyScope::Coordination,
        "joint-rti",
        SWITCH,
        "whether the RTI is part of a board's image: of the board with the RTI's address, or of the only board",
        |reader, key, value| reader.target.joint_rti = reader.boolean(key, value).unwrap_or_default(),
    ),
    property(
        PropertyScope::Coordination,
        "joint-rti-options",
        &["{ port: 15045 }", "{ federation-id: \"grid\" }"],
        "the port of the RTI, and the federation id",
        |reader, key, value| reader.joint_rti_options(key, value),
    ),
    property(
        PropertyScope::Program,
        "platform",
        &["Zephyr", "Linux", "Native", "{ name: Zephyr, board: \"qemu_cortex_m3\", user-threads: 2 }"],
        "the platform without a deployment file, and the maximum number of threads that bodies start",
        |reader, key, value| reader.platform(key, value),
    ),
    property(
        PropertyScope::Program,
        "timeout",
        &["10 sec"],
        "the logical time after which the program stops",
        |reader, key, value| reader.target.timeout_ns = reader.time(key, value),
    ),
    property(PropertyScope::Program, "fast", SWITCH, "do not wait for physical time", |reader, key, value| {
        reader.target.fast = reader.boolean(key, value).unwrap_or_default();
    }),
    property(
        PropertyScope::Program,
        "keepalive",
        SWITCH,
        "in C, continue while there are no events, because of threads that the runtime does not know; in Rust a \
         program continues as long as a thread or another federate can make one",
        |reader, key, value| {
            let given = reader.boolean(key, value);
            reader.target.keepalive = given.unwrap_or_default();
            if reader.target.language.facts().unknown_threads {
                reader.target.c.keepalive = given;
            }
        },
    ),
    property(
        PropertyScope::Program,
        "logging",
        &["error", "warn", "info", "log", "debug"],
        "the lowest level of printed log messages",
        |reader, key, value| reader.logging(key, value),
    ),
    property(
        PropertyScope::Program,
        "threading",
        SWITCH,
        "with `false`, one thread runs all reactions, whatever `workers` says",
        switch,
    ),
    property(PropertyScope::Program, "single-threaded", SWITCH, "with `true`, the same", switch),
    property(
        PropertyScope::Program,
        "workers",
        &["1", "4"],
        "the number of threads on Linux that run reactions of different reactors in parallel, with the same results as \
         one",
        |reader, key, value| {
            // 0 leaves the number to the runtime, which chooses one.
            if let Some(workers) = reader.number(key, value, WORKERS_MAX) {
                reader.target.workers = u16::try_from(workers.max(1)).unwrap_or(u16::MAX);
            }
        },
    ),
    property(
        PropertyScope::Program,
        "build-type",
        &["Debug", "Test", "Release", "RelWithDebInfo", "MinSizeRel"],
        "the compilation of programs for this computer; Zephyr configures images",
        |reader, key, value| reader.build_type(key, value),
    ),
    property(
        PropertyScope::Program,
        "single-file-project",
        SWITCH,
        "no effect: generated files are not for editing",
        switch,
    ),
    property(
        PropertyScope::Program,
        "export-dependency-graph",
        SWITCH,
        "no effect: `lfz plan` prints the connections",
        switch,
    ),
    property(
        PropertyScope::Program,
        "no-compile",
        SWITCH,
        "no effect: `lfz check` and `lfz plan` compile nothing",
        |reader, key, value| {
            if reader.boolean(key, value) == Some(true) {
                reader.idle(key, "`lfz check` and `lfz plan` compile nothing");
            }
        },
    ),
    property(
        PropertyScope::Bodies(Language::Rust),
        "cargo-dependencies",
        &["{ libm: \"0.2\" }", "{ rand: { version: \"0.8\", default-features: false, features: [\"small_rng\"] } }"],
        "crates that bodies can use, see [crates and modules](crates.md)",
        |reader, key, value| reader.dependencies(key, value),
    )
    .imported(Imported::OfOtherLanguage),
    property(
        PropertyScope::Bodies(Language::Rust),
        "cargo-features",
        &["[\"cli\"]"],
        "features of generated crates: those of their dependencies",
        |reader, key, value| reader.features(key, value),
    )
    .imported(Imported::OfOtherLanguage)
    .late(),
    property(
        PropertyScope::Bodies(Language::Rust),
        "rust-include",
        &["[]"],
        "files of Rust that are modules of generated crates: `\"filters.rs\"`",
        |reader, key, value| reader.modules(key, value),
    )
    .imported(Imported::OfOtherLanguage),
    property(
        PropertyScope::Bodies(Language::Rust),
        "edition",
        &["\"2024\"", "\"2021\"", "\"2018\""],
        "the edition of Rust of bodies; 2024 when not given",
        |reader, key, value| reader.edition(key, value),
    ),
    property(
        PropertyScope::Bodies(Language::Rust),
        "c-sources",
        &["[]"],
        "files of C that are compiled with the program, see [C beside Rust](c-code.md)",
        |reader, key, value| reader.c_sources(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::Rust),
        "c-headers",
        &["[]"],
        "headers whose declarations bodies find in the module `c`: `\"driver/fan.h\"`",
        |reader, key, value| reader.c_headers(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::Rust),
        "c-include-directories",
        &["[]"],
        "folders in which C looks for headers, beside those of LF files and of `c-headers`",
        |reader, key, value| reader.c_folders(key, value),
    )
    .imported(Imported::Always),
    property(PropertyScope::Bodies(Language::Rust), "cmake-include", &["[]"], CMAKE_INCLUDE, |reader, key, value| {
        reader.cmake_include(key, value);
    })
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::Rust),
        "compile-definitions",
        &["{ LIMIT: 3 }"],
        "macros that files and headers of C have",
        |reader, key, value| reader.definitions(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::C),
        "files",
        &["\"include/hello.h\"", "[\"../c\", \"array.h\"]"],
        "files and folders that bodies can include by their own names; those of imported files count as well",
        |reader, key, value| reader.files(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::C),
        "cmake-include",
        &["\"sources.cmake\""],
        CMAKE_INCLUDE,
        |reader, key, value| reader.cmake_include(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::C),
        "protobufs",
        &["\"Person.proto\"", "[\"a.proto\", \"b.proto\"]"],
        "files with messages of Protocol Buffers, whose types bodies and ports have by protobuf-c",
        |reader, key, value| reader.protobufs(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::C),
        "compile-definitions",
        &["{ LIMIT: 3 }"],
        "macros that all files of C have",
        |reader, key, value| reader.definitions(key, value),
    )
    .imported(Imported::Always),
    property(
        PropertyScope::Bodies(Language::C),
        "compiler",
        &["\"clang\""],
        "the compiler of programs for this computer; `cc` when not given",
        |reader, key, value| {
            reader.target.c.compiler = reader.text(key, value, "the name of a compiler in quotes");
        },
    ),
    property(
        PropertyScope::Bodies(Language::C),
        "compiler-flags",
        &["\"-O2\"", "[\"-Wall\", \"-lm\"]"],
        "further arguments of that compiler",
        |reader, key, value| reader.flags(key, value),
    )
    .imported(Imported::OfOtherLanguage),
    property(
        PropertyScope::Bodies(Language::C),
        "no-source-mapping",
        SWITCH,
        "with `true`, the compiler names lines of the generated files",
        |reader, key, value| reader.target.c.no_lines = reader.boolean(key, value).unwrap_or_default(),
    ),
    property(
        PropertyScope::Bodies(Language::C),
        "scheduler",
        &["NP", "GEDF_NP", "ADAPTIVE", "{ type: STATIC, mapper: LB }"],
        "no effect: one thread runs all reactions in their order",
        |reader, key, value| reader.scheduler(key, value),
    ),
    property(
        PropertyScope::Bodies(Language::C),
        "tracing",
        SWITCH,
        "no effect: `lfz run --trace FOLDER` records what happens",
        |reader, key, _| reader.idle(key, "`lfz run --trace FOLDER` records what happens"),
    ),
];

/// Properties of LF without an effect here, each with the reason.
pub(super) const IDLE: &[(&str, &str)] = &[
    ("build", "`lfz build` compiles the program"),
    ("cmake", "`lfz build` uses CMake where `cmake-include` names a file"),
    ("cmake-args", "pass arguments to `west build`, or set variables in a `cmake-include`"),
    ("docker", "there are no containers yet; the programs run on this computer"),
    ("external-runtime-path", "the runtime is that of this compiler"),
    ("fed-setup", "a deployment file says where federates run"),
    ("no-runtime-validation", "the runtime is that of this compiler"),
    ("print-statistics", "`lfz run --trace FOLDER` records what happens"),
    ("python-version", "no bodies are in Python"),
    ("runtime-version", "the runtime is that of this compiler"),
    ("trace-plugin", "`lfz run --trace FOLDER` records what happens"),
    ("tracing", "`lfz run --trace FOLDER` records what happens"),
    ("verify", "programs are not verified here"),
];

/// Earlier names of properties in LF, each with the present one.
pub(super) const RENAMED: [(&str, &str); 3] =
    [("flags", "compiler-flags"), ("threads", "workers"), ("communication-type", "comm-type")];

/// Properties of LF that are not supported, with the alternatives.
pub(super) const REFUSED: &[(&str, &str)] = &[
    ("advance-message-interval", "write it as `coordination-options: { advance-message-interval: … }`"),
    ("cmake-init-include", "write what it says into a `cmake-include`"),
    ("sst", "remove it; `security: noise` encrypts connections with keys of `lfz keys new`"),
    ("ros2", "remove it; messages of ROS 2 can be sent as structs or arrays of bytes"),
    ("ros2-dependencies", "remove it; a `cmake-include` can find packages of ROS 2"),
];
