// SPDX-License-Identifier: Apache-2.0
//! Programs compile even if their parts have names that generated code, bodies or the language know; one program has
//! them all, so that each compiler runs once.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use lf_federations::{Lfz, Run};
use tempfile::TempDir;

/// Keywords of Rust, types and macros in its scope, and our own additions.
const OF_RUST: &str = "\
    abstract async await become box break continue do dyn else enum extern fn for gen if impl in let loop macro \
    match mod move mut override priv pub ref return static struct trait try type typeof union unsafe unsized use \
    virtual where while yield bool char f32 f64 i128 i16 i32 i64 i8 isize str u128 u16 u32 u64 u8 usize AsMut \
    AsRef Box Clone Copy Debug Default Drop Eq Extend Fn FnMut FnOnce From FromIterator Hash Into IntoIterator \
    Iterator Option Ord PartialEq PartialOrd Result Send String Sync ToString Vec drop vec println format assert \
    panic Duration EventTag FixedPayload Instant LogicalAction Multiport MultiportMut Offset Payload \
    PhysicalAction PhysicalActionRef PhysicalLink Port ReactionContext SpawnPhysicalThread Timer Watchdog \
    assert_tag_is debug delay device error heapless info log payload tag trace warn lf core std alloc test lib \
    rti federate c TABLES DESCRIPTION Storage Program Tables Federation member bank_index value serde postcard \
    lf_linux lf_model Lines LINES Level Part Tag Cell trigger port";

/// Names that reactors can have because bodies do not see them.
const OF_REACTORS: &str = "\
    Some None Ok Err Asap After ctx";

/// Keywords of C++.
const OF_CPP: &str = "\
    class namespace template typename virtual this throw try catch operator friend explicit export delete using \
    and or not xor bitand bitor compl const_cast decltype noexcept typeid wchar_t concept requires";

/// Functions of C and of LF in C, and fields of a body's arguments.
const OF_C: &str = "\
    printf malloc free exit abort memcpy memset strlen clock sleep usleep read write open close index signal \
    select socket send recv bind listen accept connect y0 j1 jn gamma pow sin exp log floor round environ optarg \
    div abs rand srand remove puts getc assert size_t int32_t string byte interval_t instant_t tag_t FILE \
    schedule reactor_t token_t trigger action_t port value is_present length token parent environment event \
    vector_t lf width member_index x out in y";

fn written(folder: &TempDir, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, text).expect("the folder is this test's");
    path
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Lets rustc and the compilers of C check the program.
fn compiles(file: &Path) {
    let mut command = Lfz::command(["check", "--bodies"]);
    command.arg(file).arg("--out").arg(file.with_extension("out"));
    Run::start(command).succeed();
}

/// Compiles a program of these reactors, and for each declaration of one that declares all names.
fn compile_with_lists(mut text: String, mut main: String, names: &BTreeSet<&str>, lists: &[(&str, &str)]) {
    for (reactor, declaration) in lists {
        let all: String = names.iter().map(|name| declaration.replace('@', name) + "\n  ").collect();
        let _ = writeln!(text, "reactor {reactor} {{\n  {all}reaction(shutdown) {{= =}}\n}}");
        let _ = writeln!(main, "  the_{reactor} = new {reactor}()");
    }
    let folder = folder();
    compiles(&written(&folder, "Names.lf", &format!("{text}main reactor {{\n{main}}}\n")));
}

#[test]
fn parts_called_like_what_rust_or_generated_code_knows_compile() {
    let names: BTreeSet<&str> = OF_RUST.split_whitespace().collect();
    let (mut text, mut main) = (String::from("target Rust\n"), String::new());
    for name in names.iter().copied().chain(OF_REACTORS.split_whitespace()) {
        let own = if names.contains(name) { name } else { "other" };
        let _ = writeln!(
            text,
            "reactor {name}({own}: u32 = 1, q: String = {{= \"a\".into() =}}) {{\n  input {own}: Vec<u8>\n  \
             output[2] o: String\n  state {own}: Option<u32> = {{= Some(1) =}}\n  state s: Box<u8> = {{= \
             Box::new(3) =}}\
             \n  timer t(0, 1 sec)\n  logical action a: String\n  reaction(startup) -> a {{= let _x: Result<u8, \
             String> \
             = Ok(*self.s); =}}\n  reaction(t, a) {own} -> o {{= ctx.set(&mut o[0], String::from(\"x\")); =}}\n}}"
        );
        let _ = writeln!(main, "  instance_of_{name} = new {name}()");
    }
    let lists = [
        ("Actions", "logical action @: String\n  reaction(@) {= =}"),
        ("Physical", "physical action @: u8\n  reaction(@) {= =}"),
        ("Timers", "timer @(0, 1 sec)\n  reaction(@) {= =}"),
        ("Outputs", "output @: Option<String>\n  reaction(startup) -> @ {= =}"),
        ("Inputs", "input[2] @: u8\n  reaction(@) {= =}"),
        ("Watchdogs", "watchdog @(1 sec) {= =}\n  reaction(startup) -> @ {= =}"),
        ("Instances", "@ = new Leaf()"),
        ("States", "state @: u8 = 1"),
    ];
    text.push_str("reactor Leaf { input i: u8; output o: String; reaction(i) -> o {= =} }\n");
    compile_with_lists(text, main, &names, &lists);
}

/// The program itself declares all types with these names: generated code mentions nothing that they could hide.
#[test]
fn types_called_like_what_rust_or_bodies_know_compile() {
    let types = "Box Default Drop Eq Extend Fn From Hash Into Iterator Option Ord PartialEq Result Send String Sync
                 Vec Duration EventTag FixedPayload Instant LogicalAction Multiport MultiportMut Offset Payload
                 PhysicalAction PhysicalLink Port ReactionContext SpawnPhysicalThread Timer Watchdog A";
    let types: Vec<_> = types.split_whitespace().map(|name| format!("  pub struct {name} {{ pub x: u8 }}\n")).collect();
    let types = types.concat();
    let text = format!(
        "target Rust\npreamble {{=\n{types}  pub enum E {{ None, Some(u8), Ok, Err }}\n  pub use E::*;\n  pub const \
         After: u8 = 1;\n=}}\nreactor A(p: u8 = 1, q: time = 1 sec) {{\n  input i: Option\n  output o: String\n  \
         output[2] m: Vec\n  logical action a: Box\n  physical action b(1 sec): u8\n  timer t(0, 1 sec)\n  state s: \
         u8\n \
         state u: time = 2 sec\n  reset state r: u8 = 1\n  reaction(startup) -> o, m, a {{= ctx.set(o, String {{ x: \
         1 }}); \
         =}}\n  reaction(t, b) i -> a {{= =}}\n  watchdog w(1 sec) {{= =}}\n  initial mode M {{ reaction(t) -> \
         reset(N) \
         {{= =}} }}\n  mode N {{ reaction(t) {{= =}} }}\n}}\nreactor B {{ input i: String; reaction(i) {{= =}} \
         }}\nmain \
         reactor {{ a = new A(p = 2); b = new B(); a.o -> b.i }}\n"
    );
    let folder = folder();
    compiles(&written(&folder, "Types.lf", &text));
}

#[test]
fn code_means_what_the_file_declares_that_it_is_written_in() {
    let folder = folder();
    written(
        &folder,
        "Base.lf",
        "target Rust\npreamble {=\n  const LIMIT: usize = 3;\n  pub struct Payload { pub x: u8 }\n  pub struct Thing { \
         pub a: [u8; LIMIT] }\n  fn help() -> usize { LIMIT }\n=}\nreactor Base(size: usize = {= LIMIT =}) {\n  state \
         a: {= [u8; LIMIT] =} = {= [0; LIMIT] =}\n  output o: Payload\n  logical action b: Thing\n  \
         reaction(startup) -> \
         o, b {= println!(\"base {LIMIT} {} {} {}\", self.size, self.a.len(), help()); =}\n}\n",
    );
    let file = written(
        &folder,
        "Heir.lf",
        "target Rust\nimport Base from \"Base.lf\"\npreamble {=\n  const LIMIT: usize = 5;\n  pub struct Thing;\n  fn \
         help() -> usize { LIMIT }\n=}\nreactor Heir extends Base {\n  state c: {= [u8; LIMIT] =} = {= [0; LIMIT] \
         =}\n \
         logical action d: Thing\n  reaction(startup) -> d {= println!(\"heir {LIMIT} {} {}\", self.c.len(), help()); \
         =}\n}\nmain reactor { a = new Heir() }\n",
    );
    let finished = Lfz::run("names_of_files", &file, &[]).succeed();
    for expected in ["base 3 3 3 3", "heir 5 5 5"] {
        assert!(finished.lines.iter().any(|line| line == expected), "{finished}");
    }
}

#[test]
fn parts_called_like_what_c_or_its_libraries_know_compile() {
    for (target, words) in [("C", OF_CPP), ("CCpp", "")] {
        let (mut text, mut main) = (format!("target {target}\n"), String::new());
        let names: BTreeSet<&str> = OF_C.split_whitespace().chain(words.split_whitespace()).collect();
        for name in &names {
            let _ = writeln!(
                text,
                "reactor {name}({name}: int = 1) {{\n  input {name}: int\n  output[2] o: int\n  timer t(0, 1 sec)\n  \
                 logical action a: int\n  reaction(startup) -> a {{= lf_schedule(a, MSEC(1)); =}}\n  reaction(t, a) \
                 {name} -> o {{= lf_set(o[0], 1); =}}\n}}"
            );
            let _ = writeln!(main, "  instance_of_{name} = new {name}()");
        }
        let lists = [
            ("Actions", "logical action @: int\n  reaction(@) {= =}"),
            ("Timers", "timer @(0, 1 sec)\n  reaction(@) {= =}"),
            ("Outputs", "output @: int\n  reaction(startup) -> @ {= lf_set(@, 1); =}"),
            ("Inputs", "input[2] @: int\n  reaction(@) {= =}"),
            ("Instances", "@ = new Leaf()"),
            ("States", "state @: int = 1"),
        ];
        text.push_str("reactor Leaf { input i: int; output o: int; reaction(i) -> o {= =} }\n");
        compile_with_lists(text, main, &names, &lists);
    }
}

#[test]
fn programs_in_files_called_like_packages_and_folders_of_cargo_run() {
    let names = ["2Motors", "Build", "Log", "Test", "Core", "Match", "Serde", "LfLinux", "con", "a.b", "Ünï"];
    let long = "LongName".repeat(12);
    for name in names.into_iter().chain([long.as_str()]) {
        let folder = folder();
        let text = "target Rust\nmain reactor { reaction(startup) {= println!(\"it runs\"); =} }\n";
        let file = written(&folder, &format!("{name}.lf"), text);
        let finished = Run::start({
            let mut command = Lfz::command(["run"]);
            command.arg(&file);
            command
        })
        .succeed();
        assert!(finished.lines.iter().any(|line| line == "it runs"), "{name}: {finished}");
    }
}
