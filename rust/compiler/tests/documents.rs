// SPDX-License-Identifier: Apache-2.0
//! The tables in the documents match the compiler, and the boards on which the tests run.
//!
//! `cargo xtask bless -p lf-compiler documents::` rewrites them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use lf_compiler::deployment::Platform;
use lf_compiler::plan::Language;
use lf_compiler::{PropertyScope, SourceProvider, Style, TargetProperty, compile, supported};

/// A reactor in which the examples below are valid.
const AROUND: &str = "reactor Child(gain: i32 = 1) { input x: i32  output y: i32 }
reactor Parent {
  input x: i32
  output y: i32
  timer tick(0, 1 s)
  state count: i32 = 0
  logical action later: i32
  a = new Child()
  b = new Child()
";

/// Supported parts of the language, each with its notation. `…` stands for anything, or nothing.
const MEMBERS: &[(&str, &str)] = &[
    ("inputs and outputs", "output voltage: f64"),
    ("state variables", "state limit: u32 = 5"),
    ("timers", "timer t(0, 20 ms)"),
    ("logical actions", "logical action again(5 ms): u32"),
    ("physical actions", "physical action button(0, 1 ms): bool"),
    ("reactions", "reaction(startup, x, tick) -> later {= … =}"),
    ("reactions to contained reactors, and to their inputs", "reaction(a.y) -> b.x {= … =}"),
    ("deadlines", "reaction(x) {= … =} deadline(5 ms) {= … =}"),
    ("preambles", "preamble {= const LIMIT_V: i32 = 23; =}"),
    ("reactors in reactors", "child = new Child(gain = 2)"),
    ("connections, through the hierarchy too", "x -> a.x"),
    ("several connections at once, broadcasts", "(x)+ -> a.x, b.x"),
    ("connections with a delay", "a.y -> b.x after 10 ms"),
    ("physical connections", "a.y ~> b.x"),
    ("multiports", "input[3] channels: i32  output[2] more: i32"),
    ("banks of reactors", "bank = new[3] Child()  (x)+ -> bank.x"),
    ("`interleaved`", "output[2] out: i32  bank = new[2] Child()  interleaved(bank.y) -> out"),
    ("modes", "initial mode On { reaction(x) -> reset(Off) {= … =} }  mode Off { reaction(x) -> history(On) {= … =} }"),
    ("`reset` state variables", "reset state limit: u32 = 5"),
    ("the trigger `reset`", "reaction(reset) {= … =}"),
    ("watchdogs", "watchdog silence(50 ms) -> later {= … =}  reaction(x) -> silence {= … =}"),
    ("methods", "const method twice(x: i32): i32 {= x * 2 =}"),
    ("how many events a queue holds (ours)", "@capacity(16) logical action again: u32"),
    ("how long texts and lists between federates are (ours)", "@max_length(80) output text: String"),
    ("how values between federates become bytes", "a.y -> b.x serializer \"postcard\""),
];

/// Supported parts of files.
const FILES: &[(&str, &str)] = &[
    ("parameters of reactors", "reactor Sensor(period: time = 10 ms, unit: usize = 0) { … }"),
    ("inheritance", "reactor Base { input x: i32 }  reactor Derived extends Base { reaction(x) {= … =} }"),
    ("type parameters", "reactor Box<T> { input x: T }  reactor User { numbers = new Box<u32>() }"),
    ("imports from files", "import Sensor from \"lib/Sensor.lf\""),
    ("programs of one reactor", "main reactor { … }"),
];

/// Supported parts of federations.
const FEDERATIONS: &[(&str, &str)] = &[
    ("federations", "federated reactor { a = new Child() }"),
    (
        "cycles of federates without delay",
        "federated reactor { a = new Child()  b = new Child()  a.y, b.y -> b.x, a.x }",
    ),
    ("banks of federates", "federated reactor { members = new[3] Child() }"),
    (
        "reactions of the federated reactor, in the federate whose ports they name, or in all",
        "federated reactor { a = new Child()  reaction(startup) -> a.x {= … =} }",
    ),
    ("where the RTI is", "federated reactor at 10.0.0.1:15045 { a = new Child() }"),
];

/// Supported parts of decentralized federations.
const DECENTRALIZED: &[(&str, &str)] = &[
    ("decentralized: how long a federate waits for inputs", "federated reactor { @maxwait(10 ms) a = new Child() }"),
    (
        "decentralized: how long it waits within a tag",
        "federated reactor { a = new Child()  b = new Child()  @absent_after(5 ms) a.y -> b.x }",
    ),
    (
        "decentralized: what happens when a message is late",
        "reactor Late { input x: i32  reaction(x) {= … =} tardy {= … =} }",
    ),
];

struct OneFile(String);

impl SourceProvider for OneFile {
    fn read(&self, path: &str) -> Result<String, String> {
        let is_library = path.starts_with("lib/");
        Ok(if is_library { "target Rust\nreactor Sensor { }".to_owned() } else { self.0.clone() })
    }
}

/// Compiles a program that has to be correct.
fn check(program: &str) {
    let program = program.replace('…', "");
    let compilation = compile("Example.lf", &OneFile(program.clone()));
    assert!(compilation.plan.is_some(), "{}\n{program}", compilation.diagnostics.render(Style::Plain));
}

#[test]
fn every_example_in_the_table_of_the_language_compiles() {
    for (_, example) in MEMBERS {
        check(&format!("target Rust\n{AROUND}{example}\n}}\nmain reactor {{ p = new Parent() }}"));
    }
    for (_, example) in FILES {
        let main = if example.starts_with("main") { "" } else { "main reactor { }" };
        check(&format!("target Rust\n{example}\n{main}"));
    }
    for (_, example) in FEDERATIONS {
        check(&format!("target Rust\n{AROUND}}}\n{example}"));
    }
    for (_, example) in DECENTRALIZED {
        let main = if example.starts_with("federated") { "" } else { "federated reactor { late = new Late() }" };
        check(&format!("target Rust {{ coordination: decentralized }}\n{AROUND}}}\n{example}\n{main}"));
    }
}

#[test]
fn every_target_property_takes_the_values_in_its_table() {
    for language in Language::ALL {
        let is_other = |scope: PropertyScope| matches!(scope, PropertyScope::Bodies(other) if other != language);
        for TargetProperty { name, values, .. } in supported().properties.iter().filter(|it| !is_other(it.scope)) {
            for value in *values {
                let program = format!("{AROUND}}}\nfederated reactor {{ a = new Parent() }}");
                check(&format!("target {language} {{ {name}: {value} }}\n{program}"));
            }
        }
    }
}

#[test]
fn the_documents_have_the_tables_of_what_is_supported() {
    let supported = supported();
    let mut language = "| part of LF | written so |\n|---|---|\n".to_owned();
    for (part, example) in FILES.iter().chain(MEMBERS).chain(FEDERATIONS).chain(DECENTRALIZED) {
        writeln!(language, "| {part} | `{example}` |").expect("a text takes all");
    }
    let mut missing = "| part of LF | instead |\n|---|---|\n".to_owned();
    for (part, instead) in supported.refused {
        writeln!(missing, "| {part} | {instead} |").expect("a text takes all");
    }
    let mut refused = "| target property | instead |\n|---|---|\n".to_owned();
    for (name, instead) in supported.refused_properties {
        writeln!(refused, "| `{name}` | {instead} |").expect("a text takes all");
    }
    let mut idle = "| target property | why |\n|---|---|\n".to_owned();
    for (name, reason) in supported.idle_properties {
        writeln!(idle, "| `{name}` | {reason} |").expect("a text takes all");
    }
    rewrite("README.md", "refused", &missing);
    rewrite("README.md", "boards", &boards());
    rewrite("docs/guide/src/supported.md", "language", &language);
    rewrite("docs/guide/src/configuration.md", "coordination", &properties(PropertyScope::Coordination));
    rewrite("docs/guide/src/configuration.md", "properties", &properties(PropertyScope::Program));
    rewrite(
        "docs/guide/src/configuration.md",
        "properties of Rust",
        &properties(PropertyScope::Bodies(Language::Rust)),
    );
    rewrite("docs/guide/src/configuration.md", "properties of C", &properties(PropertyScope::Bodies(Language::C)));
    rewrite("docs/guide/src/configuration.md", "refused properties", &refused);
    rewrite("docs/guide/src/configuration.md", "idle properties", &idle);
}

fn properties(scope: PropertyScope) -> String {
    let mut table = "| target property | values | meaning |\n|---|---|---|\n".to_owned();
    for TargetProperty { name, values, does, .. } in supported().properties.iter().filter(|it| it.scope == scope) {
        writeln!(table, "| `{name}` | `{}` | {does} |", values.join("`, `")).expect("a text takes all");
    }
    table
}

/// Returns the boards that have a file of settings, with its first sentences, and the use of each in tests.
fn boards() -> String {
    let suites = words(&texts(&["tests/zephyr", "applications"], &["testcase.yaml", "sample.yaml"]));
    let deployed = words(&texts(&["applications", "scripts/tests/programs"], &[".yaml"]));
    let mut table = "| board | what it is | what the tests do |\n|---|---|---|\n".to_owned();
    let files = files(&repository().join("boards"));
    for file in files.iter().filter(|file| file.extension().is_some_and(|kind| kind == "conf")) {
        let name = file.file_stem().expect("the file has a name").to_string_lossy();
        let board = deployed.get(&*name).or(suites.get(&*name)).expect("a test knows the board");
        let text = fs::read_to_string(file).expect("the file can be read");
        let about: Vec<&str> = text.lines().skip(1).map_while(|line| line.strip_prefix("# ")).collect();
        let tested = match (suites.contains_key(&*name), Platform::Zephyr(board.clone()).is_virtual()) {
            (true, _) => "run twister suites and federations",
            (false, true) => "run federations",
            (false, false) => "build images",
        };
        writeln!(table, "| `{board}` | {} | {tested} |", about.join(" ")).expect("a text takes all");
    }
    table
}

/// Returns the joined texts of all files in these folders whose paths have such an end.
fn texts(folders: &[&str], ends: &[&str]) -> String {
    let files = folders.iter().flat_map(|folder| files(&repository().join(folder)));
    let chosen = files.filter(|file| ends.iter().any(|end| file.to_string_lossy().ends_with(end)));
    chosen.map(|file| fs::read_to_string(file).expect("the file can be read")).collect()
}

/// Returns the words of a text that could be boards, by their form in file names: without revision.
fn words(text: &str) -> BTreeMap<String, String> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "_/@".contains(c)));
    let in_file_names = |word: &str| {
        let parts = word.split('/').map(|part| part.split('@').next().unwrap_or(part));
        parts.collect::<Vec<_>>().join("_")
    };
    words.map(|word| (in_file_names(word), word.to_owned())).collect()
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns all files below a folder, except for build output, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder is part of the repository");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be listed").path()).collect();
    paths.sort();
    let kept = paths.into_iter().filter(|path| !path.ends_with("build"));
    kept.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Compares the text between the marks of this table with the expected one, or writes it.
fn rewrite(document: &str, table: &str, expected: &str) {
    let file = repository().join(document);
    let text = fs::read_to_string(&file).expect("the document is part of the repository");
    let (begin, end) =
        (format!("<!-- {table}: written by `cargo xtask bless` -->\n"), format!("<!-- {table}: end -->"));
    let (before, rest) = text.split_once(&begin).expect("the document says where the table begins");
    let (found, after) = rest.split_once(&end).expect("the document says where the table ends");
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        fs::write(&file, format!("{before}{begin}\n{expected}\n{end}{after}")).expect("the document can be written");
    } else {
        assert_eq!(found.trim(), expected.trim(), "`cargo xtask bless` writes this table into {document}");
    }
}
