// SPDX-License-Identifier: Apache-2.0
//! The target properties that there are, and those that are refused.

use crate::lexical::Language;

/// A target property that is honoured, as the documents describe it.
#[derive(Clone, Copy, Debug)]
pub struct TargetProperty {
    /// Its name.
    pub name: &'static str,
    /// Values that it takes, as they are written in a program.
    pub values: &'static [&'static str],
    /// What it does, in Markdown.
    pub does: &'static str,
}

const fn property(name: &'static str, values: &'static [&'static str], does: &'static str) -> TargetProperty {
    TargetProperty { name, values, does }
}

const SWITCH: &[&str] = &["true", "false"];

/// Properties that are honoured and say how federates work together.
pub(super) const COORDINATION: &[TargetProperty] = &[
    property(
        "coordination",
        &["centralized", "decentralized"],
        "who decides when a tag begins: the RTI, or each federate when its waits are over",
    ),
    property(
        "coordination-options",
        &["{ log-waits: 500 ms }", "{ advance-message-interval: 10 ms }"],
        "who waits for longer than `log-waits` says for whom; how often a federate with physical actions tells its \
         progress",
    ),
    property("DNET", SWITCH, "whether the RTI may tell federates which progress nobody needs to know"),
    property(
        "clock-sync",
        &["off", "init", "on"],
        "when clocks are compared with the RTI's: never, before the start, all the time",
    ),
    property(
        "clock-sync-options",
        &[
            "{ trials: 10 }",
            "{ period: 5 ms }",
            "{ attenuation: 10 }",
            "{ local-federates-on: true }",
            "{ test-offset: 1 ms }",
            "{ collect-stats: true }",
        ],
        "how often they are compared, and what is made of it",
    ),
    property("auth", SWITCH, "whether the RTI and the federates prove to each other that they know the federation id"),
    property(
        "joint-rti",
        SWITCH,
        "whether the RTI is part of a board's image: of the board with the RTI's address, or of the only board",
    ),
    property(
        "joint-rti-options",
        &["{ port: 15045 }", "{ federation-id: \"grid\" }"],
        "the port of the RTI, and the federation id",
    ),
];

/// All other properties that are honoured.
pub(super) const PROGRAM: &[TargetProperty] = &[
    property(
        "platform",
        &["Zephyr", "Linux", "Native", "{ name: Zephyr, board: \"qemu_cortex_m3\", user-threads: 2 }"],
        "where the program runs unless a deployment says otherwise, and how many threads its bodies may start",
    ),
    property("timeout", &["10 sec"], "stop when so much logical time has passed"),
    property("fast", SWITCH, "do not wait for physical time"),
    property(
        "keepalive",
        SWITCH,
        "in C, go on while there are no events, because of threads that nobody knows of; in Rust a program goes on as \
         long as a thread or another federate can make one",
    ),
    property("logging", &["error", "warn", "info", "log", "debug"], "which log messages are shown"),
    property("threading", SWITCH, "with `false`, one thread runs all reactions, whatever `workers` says"),
    property("single-threaded", SWITCH, "with `true`, the same"),
    property(
        "workers",
        &["1", "4"],
        "how many threads run reactions of different reactors side by side on Linux, with the same results as one",
    ),
    property(
        "build-type",
        &["Debug", "Test", "Release", "RelWithDebInfo", "MinSizeRel"],
        "how programs for this computer are compiled; images are configured by Zephyr",
    ),
    property("single-file-project", SWITCH, "no effect: nobody edits what is generated"),
    property("export-dependency-graph", SWITCH, "no effect: `lfz plan` prints what is connected to what"),
    property("no-compile", &["false"], "no effect: `lfz check` and `lfz plan` compile nothing"),
];

const CMAKE_INCLUDE: &str = "what is told to CMake: everything for an image; for this computer sources, definitions, \
                             folders of headers, options and libraries";

/// Properties of programs whose bodies are Rust.
pub(super) const RUST: &[TargetProperty] = &[
    property(
        "cargo-dependencies",
        &["{ libm: \"0.2\" }", "{ rand: { version: \"0.8\", default-features: false, features: [\"small_rng\"] } }"],
        "crates that bodies can use, see [crates and modules](crates.md)",
    ),
    property("cargo-features", &["[\"cli\"]"], "features of generated crates: those of their dependencies"),
    property("rust-include", &["[]"], "files of Rust that are modules of generated crates: `\"filters.rs\"`"),
    property("edition", &["\"2024\"", "\"2021\"", "\"2018\""], "the edition of Rust of bodies; 2024 when not given"),
    property("c-sources", &["[]"], "files of C that are compiled with the program, see [C beside Rust](c-code.md)"),
    property("c-headers", &["[]"], "headers whose declarations bodies find in the module `c`: `\"driver/fan.h\"`"),
    property(
        "c-include-directories",
        &["[]"],
        "folders in which C looks for headers, beside those of LF files and of `c-headers`",
    ),
    property("cmake-include", &["[]"], CMAKE_INCLUDE),
    property("compile-definitions", &["{ LIMIT: 3 }"], "macros that files and headers of C have"),
];

/// Properties of programs whose bodies are C.
pub(super) const C: &[TargetProperty] = &[
    property(
        "files",
        &["\"include/hello.h\"", "[\"../c\", \"array.h\"]"],
        "files and folders that bodies can include by their own names; those of imported files count as well",
    ),
    property("cmake-include", &["\"sources.cmake\""], CMAKE_INCLUDE),
    property("compile-definitions", &["{ LIMIT: 3 }"], "macros that all files of C have"),
    property("compiler", &["\"clang\""], "the compiler of programs for this computer; `cc` when not given"),
    property("compiler-flags", &["\"-O2\"", "[\"-Wall\", \"-lm\"]"], "what else that compiler is told"),
    property("no-source-mapping", SWITCH, "with `true`, the compiler names lines of the generated files"),
    property("scheduler", &["NP", "GEDF_NP", "ADAPTIVE"], "no effect: one thread runs all reactions in their order"),
    property("tracing", SWITCH, "no effect: `lfz run --trace FOLDER` records what happens"),
];

/// The language that a property belongs to which programs in this one do not have.
pub(super) fn language_of(name: &str, language: Language) -> Option<Language> {
    let has = |table: &[TargetProperty]| table.iter().any(|known| known.name == name);
    let mut owners =
        [(Language::Rust, RUST), (Language::C, C)].into_iter().filter(|(_, table)| has(table)).map(|(owner, _)| owner);
    let first = owners.next()?;
    (first != language && owners.all(|owner| owner != language)).then_some(first)
}

/// The names of all properties that are honoured in programs of a language.
pub(super) fn honoured(language: Language) -> impl Iterator<Item = &'static str> + Clone {
    let own = match language {
        Language::Rust => RUST,
        Language::C => C,
    };
    COORDINATION.iter().chain(PROGRAM).chain(own).map(|known| known.name)
}

/// Properties of LF that are not, with what to do instead.
pub(super) const REFUSED: &[(&str, &str)] = &[
    ("advance-message-interval", "write it as `coordination-options: { advance-message-interval: … }`"),
    ("build", "remove it"),
    ("runtime-version", "remove it"),
    ("external-runtime-path", "remove it"),
    ("docker", "remove it"),
    ("tracing", "remove it; `lfz run --trace FOLDER` records what happens"),
    ("trace-plugin", "remove it"),
    ("cmake-init-include", "remove it"),
    ("cmake-args", "remove it; pass arguments to `west build`"),
    ("protobufs", "remove it"),
    ("communication-type", "remove it; federates talk over TCP"),
    ("comm-type", "remove it; federates talk over TCP"),
    ("sst", "remove it"),
    ("fed-setup", "remove it"),
    ("verify", "remove it"),
    ("print-statistics", "remove it"),
    ("no-runtime-validation", "remove it"),
    ("python-version", "remove it"),
    ("ros2", "remove it"),
    ("ros2-dependencies", "remove it"),
];
