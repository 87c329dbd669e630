// SPDX-License-Identifier: Apache-2.0
//! The language server's help while typing and reading: completion, descriptions with the plan's facts, renames, fixes,
//! colours, folds, commands and waits.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::lsp::Editor;

const GRID: &str = "target Rust { coordination: decentralized }
import Meter from \"meter.lf\"
// Shows values.
reactor Show(limit: u32 = 3) {
  @capacity(7)
  input x: u32
  output y: u32
  state last: u32 = 0
  timer t(0, 20 ms)
  @capacity(5)
  logical action again(1 ms): u32
  reaction(x, again) -> y, again {=
    let x = ctx.get(x).unwrap_or(self.last);
    self.last = x + self.limit; // x and last
    println!(\"{x} {}\", self.last);
    ctx.set(y, x);
  =}
  reaction(t) {= =} deadline(2 ms) {= =}
}
federated reactor {
  @maxwait(20 ms)
  a = new Show(limit = 2)
  b = new Meter() // measures
  b.count -> a.x after 5 ms
  a.y -> b.clear
}
";
const METER: &str = "target Rust
reactor Meter {
  input clear: u32
  output count: u32
  reaction(clear) -> count {= let clear = ctx.get(clear); ctx.set(count, 1); =}
}
";

fn labels(answer: &Value) -> Vec<String> {
    let all = answer.as_array().into_iter().flatten();
    all.map(|item| item["label"].as_str().unwrap_or_default().to_owned()).collect()
}

/// Returns an editor with both files.
fn editor() -> Editor {
    let mut editor = Editor::start();
    editor.open("meter.lf", METER);
    editor.open("Grid.lf", GRID);
    assert_eq!(editor.diagnostics("Grid.lf"), json!([]));
    editor
}

#[test]
fn completion_knows_what_a_place_asks_for() {
    let mut editor = editor();
    let c = "target C\nreactor R { input i: int\n state n: int = 0\n reaction(i) {= ";
    let mut answers = String::new();
    for (text, wanted) in [
        ("target Rust { coordination: |}", "decentralized"),
        ("target Rust { clock-sync-options: { |}}", "trials"),
        ("target Rust { | }", "cargo-dependencies"),
        ("target C { | }", "compiler-flags"),
        ("target Rust { timeout: 10 |}", "ms"),
        ("target Rust\nimport | from \"meter.lf\"", "Meter"),
        ("target Rust\nimport Meter from |", "\"meter.lf\""),
        ("target Rust\nimport Meter from \"|\"", "meter.lf"),
        ("target Rust\nreactor R {\n  @|\n  input x: u8\n}", "capacity"),
        ("target Rust\nreactor A(size: u8 = 1) {}\nreactor R { a = new A(|) }", "size"),
        ("target Rust\nreactor R { input x: u8 timer t\n  reaction(|) {= =} }", "t"),
        ("target Rust\nreactor R { input x: u8 output y: u8\n  reaction(x) -> | {= =} }", "y"),
        ("target Rust\nreactor R { state n: u8 input x: u8\n  reaction(x) {= self.| =} }", "n"),
        ("target Rust\nreactor R { state n: u8 input x: u8\n  reaction(x) {= ctx.| =} }", "get_ref"),
        ("target Rust\nreactor R { state n: u8 input x: u8\n  reaction(x) {= | =} }", "x"),
        ("target Rust\nreactor A { output y: u8 }\nreactor R { a = new A() reaction(a.y) {= | =} }", "a__y"),
        (&format!("{c}self->| =}} }}"), "n"),
        (&format!("{c}i->| =}} }}"), "is_present"),
        (&format!("{c}lf_| =}} }}"), "lf_set"),
    ] {
        let at = text.find('|').expect("it has a mark");
        editor.change("Grid.lf", &text.replacen('|', "", 1));
        let position = json!({ "line": text[..at].matches('\n').count(),
            "character": text[..at].rsplit('\n').next().unwrap_or_default().chars().count() });
        let uri = editor.uri("Grid.lf");
        let asked = json!({ "textDocument": { "uri": uri }, "position": position });
        let all = labels(&editor.ask("textDocument/completion", &asked));
        assert!(all.iter().any(|label| label == wanted), "{text}: {all:?}");
        writeln!(answers, "{text}\n  {}\n", all.join(", ")).unwrap();
    }
    insta::assert_snapshot!(answers);
    editor.end();
}

#[test]
fn descriptions_have_times_levels_capacities_and_waits() {
    let mut editor = editor();
    let mut answers = String::new();
    for (text, behind) in [
        ("t(0", 0),
        ("again(1", 0),
        ("x: u32", 0),
        ("reaction(x", 2),
        ("reaction(t", 2),
        ("a = new", 0),
        ("b = new", 0),
    ] {
        let answer = editor.ask_in("Grid.lf", GRID, "textDocument/hover", text, behind);
        writeln!(answers, "{text}\n{}\n", answer["contents"]["value"].as_str().unwrap_or_default()).unwrap();
    }
    // A name in a body is described where it stands.
    let state = editor.ask_in("Grid.lf", GRID, "textDocument/hover", "last = x", 1);
    assert_eq!(state["contents"]["value"], "```lf\nstate last: u32\n```");
    // A file that is imported has the facts of the open program.
    let imported = editor.ask_in("meter.lf", METER, "textDocument/hover", "clear: u32", 0);
    writeln!(answers, "clear\n{}", imported["contents"]["value"].as_str().unwrap_or_default()).unwrap();
    insta::assert_snapshot!(answers);
    editor.end();
}

fn number(value: &Value) -> usize {
    value.as_u64().and_then(|number| usize::try_from(number).ok()).expect("it is a number")
}

/// Returns the text of a file after the changes of an answer.
fn changed(editor: &Editor, answer: &Value, name: &str, text: &str) -> String {
    let mut edits = answer["changes"][editor.uri(name)].as_array().cloned().unwrap_or_default();
    let byte = |place: &Value| {
        let line: usize = text.split_inclusive('\n').take(number(&place["line"])).map(str::len).sum();
        line + number(&place["character"])
    };
    edits.sort_by_key(|edit| std::cmp::Reverse(byte(&edit["range"]["start"])));
    let mut changed = text.to_owned();
    for edit in edits {
        let (start, end) = (byte(&edit["range"]["start"]), byte(&edit["range"]["end"]));
        changed.replace_range(start..end, edit["newText"].as_str().unwrap());
    }
    changed
}

#[test]
fn a_name_is_changed_in_all_files_and_in_bodies() {
    let mut editor = editor();
    let at = editor.place("Grid.lf", GRID, "count -> a", 0);
    let prepared = editor.ask("textDocument/prepareRename", &at);
    assert_eq!(prepared["placeholder"], "count");
    let rename = |editor: &mut Editor, text: &str, new: &str| {
        let mut asked = editor.place("Grid.lf", GRID, text, 0);
        asked["newName"] = json!(new);
        editor.ask_for("textDocument/rename", &asked)
    };
    let answer = rename(&mut editor, "count -> a", "total")["result"].clone();
    assert_eq!(changed(&editor, &answer, "Grid.lf", GRID), GRID.replace("b.count", "b.total"));
    assert_eq!(
        changed(&editor, &answer, "meter.lf", METER),
        METER.replace("output count", "output total").replace("> count", "> total").replace("set(count", "set(total")
    );
    let answer = rename(&mut editor, "x: u32", "value")["result"].clone();
    let expected = GRID
        .replace("input x", "input value")
        .replace("reaction(x,", "reaction(value,")
        .replace("let x = ctx.get(x)", "let value = ctx.get(value)")
        .replace("= x + self", "= value + self")
        .replace("{x}", "{value}")
        .replace("(y, x)", "(y, value)")
        .replace("a.x", "a.value");
    assert_eq!(changed(&editor, &answer, "Grid.lf", GRID), expected);
    for (text, new, why) in [
        ("x: u32", "y", "stands already"),
        ("x: u32", "reaction", "the program is wrong"),
        ("x: u32", "a-b", "is no name"),
        ("a = new", "b", "the program is wrong"),
    ] {
        let error = rename(&mut editor, text, new)["error"]["message"].clone();
        assert!(error.as_str().is_some_and(|error| error.contains(why)), "{new}: {error}");
    }
    editor.end();
}

#[test]
fn advice_is_a_quick_fix() {
    let mut editor = editor();
    let wrong = GRID.replace("coordination:", "cordination:").replace("20 ms)\n  @cap", "20)\n  @cap");
    editor.change("Grid.lf", &wrong);
    assert_ne!(editor.diagnostics("Grid.lf"), json!([]));
    let uri = editor.uri("Grid.lf");
    let fixes = |editor: &mut Editor| {
        let everywhere = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
        let asked = json!({ "textDocument": { "uri": uri }, "range": everywhere, "context": { "diagnostics": [] } });
        editor.ask("textDocument/codeAction", &asked)
    };
    let answer = fixes(&mut editor);
    assert_eq!(answer[0]["title"], "Write `coordination`");
    let better = changed(&editor, &answer[0]["edit"], "Grid.lf", &wrong);
    editor.change("Grid.lf", &better);
    let answer = fixes(&mut editor);
    assert_eq!(answer[0]["title"], "Write `20 ms`");
    assert_eq!(changed(&editor, &answer[0]["edit"], "Grid.lf", &better), GRID);
    editor.end();
}

#[test]
fn a_file_has_colours_folds_commands_and_waits() {
    let mut editor = editor();
    let document = json!({ "textDocument": { "uri": editor.uri("Grid.lf") } });
    let mut answers = String::new();
    let folds = editor.ask("textDocument/foldingRange", &document);
    for fold in folds.as_array().unwrap() {
        let kind = fold["kind"].as_str().unwrap_or("block");
        writeln!(answers, "fold {} to {}: {kind}", fold["startLine"], fold["endLine"]).unwrap();
    }
    let lenses = editor.ask("textDocument/codeLens", &document);
    for lens in lenses.as_array().unwrap() {
        let line = &lens["range"]["start"]["line"];
        writeln!(answers, "line {line}: {} {}", lens["command"]["title"], lens["command"]["command"]).unwrap();
    }
    let everywhere = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let asked = json!({ "textDocument": { "uri": editor.uri("Grid.lf") }, "range": everywhere });
    for hint in editor.ask("textDocument/inlayHint", &asked).as_array().unwrap() {
        let place = &hint["position"];
        writeln!(answers, "{}:{} {}", place["line"], place["character"], hint["label"]).unwrap();
    }
    let tokens = editor.ask("textDocument/semanticTokens/full", &document);
    let lines: Vec<&str> = GRID.lines().collect();
    let (mut line, mut start) = (0, 0);
    for token in tokens["data"].as_array().unwrap().chunks(5) {
        start = if number(&token[0]) == 0 { start + number(&token[1]) } else { number(&token[1]) };
        line += number(&token[0]);
        let kind = [
            "keyword",
            "comment",
            "string",
            "number",
            "decorator",
            "class",
            "type",
            "parameter",
            "property",
            "port",
            "event",
            "instance",
            "mode",
            "method",
            "value",
        ][number(&token[3])];
        let text = &lines[line][start..start + number(&token[2])];
        write!(answers, "{text}={kind} ").unwrap();
    }
    insta::assert_snapshot!(answers);
    editor.end();
}

/// With the bounds of the federation in `bounds.yaml` beside it, waits that are too short are told.
#[test]
fn safe_waits_follow_from_measured_bounds() {
    let mut editor = editor();
    editor.write_file("bounds.yaml", "latency: 40 ms\nclock-error: 1 ms\nexecution: 1 ms\n");
    let everywhere = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let asked = json!({ "textDocument": { "uri": editor.uri("Grid.lf") }, "range": everywhere });
    editor.change("Grid.lf", &GRID.replace("  a.y -> b.clear\n", ""));
    let hints = labels(&editor.ask("textDocument/inlayHint", &asked));
    insta::assert_snapshot!(hints.join("\n"));
    editor.end();
}
