// SPDX-License-Identifier: Apache-2.0
//! The language server with tools for bodies: with one of these tests in their place, and with the real ones where this
//! computer has them.

use std::collections::BTreeMap;
use std::env;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};

use crate::lsp::Editor;

/// The variable that says how the tool behaves.
const MODE: &str = "LF_TEST_TOOL";

const RUST: &str = "target Rust
preamble {=
  fn doubled(number: u32) -> u32 { number * 2 }
  struct Fast { speed: u32 }
=}
reactor Sum(first: u32 = {= doubled(1) =}) {
  input x: u32
  output y: u32
  state list: {= Vec<u32> =} = {= Vec::new() =}
  reaction(x) -> y {=
    let ü = \"𝄞\"; let grown = doubled(ctx.get(x).unwrap_or_default());
    self.list.push(grown);
    ctx.set(y, grown);
  =}
}
reactor Source {
  output y: u32
  reaction(startup) -> y {= ctx.set(y, 1); =}
}
federated reactor {
  source = new Source()
  sum = new Sum()
  other = new Sum(first = 2)
  source.y -> sum.x
  source.y -> other.x
}
";

const C: &str = "target C
preamble {=
  #include <math.h>
  static int doubled(int number) { return number * 2; }
=}
main reactor {
  timer t(0, 10 ms)
  state last: int = 0
  reaction(t) {= int ü = 3; self->last = doubled(7);
    lf_print(\"%d\", self->last);
  =}
}
";

/// Stands for a tool where the variable says so; otherwise it is no test.
///
/// It answers by the text that it has: what it is asked about is shown in the line of the text, so that an answer is
/// right only if both ways between the files are.
#[test]
fn tool() {
    let Ok(mode) = env::var(MODE) else { return };
    // The standard output has words of the test's runner.
    let mut output = File::options().write(true).open("/proc/self/fd/3").expect("the script has opened it");
    let mut input = BufReader::new(io::stdin());
    let mut texts: BTreeMap<String, String> = BTreeMap::new();
    let mut say = |message: Value| {
        let text = message.to_string();
        write!(output, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("lfz reads");
    };
    while let Some(message) = read(&mut input) {
        let (method, params) = (message["method"].as_str().unwrap_or_default(), &message["params"]);
        match method {
            "initialized" => {
                say(json!({ "jsonrpc": "2.0", "id": "own", "method": "window/workDoneProgress/create", "params": {} }));
                let status = json!({ "health": "ok", "quiescent": true });
                say(json!({ "jsonrpc": "2.0", "method": "experimental/serverStatus", "params": status }));
                continue;
            }
            "textDocument/didOpen" | "textDocument/didChange" => {
                let document = &params["textDocument"];
                let uri = document["uri"].as_str().unwrap().to_owned();
                let text = document.get("text").unwrap_or(&params["contentChanges"][0]["text"]);
                let text = text.as_str().unwrap().to_owned();
                let wrong = all_of(&text, "WRONG")
                    .map(|range| json!({ "range": range, "severity": 2, "message": "it is wrong", "source": "tool" }));
                let syntax = all_of(&text, "fn ")
                    .map(|range| json!({ "range": range, "message": "this is ours", "code": "syntax-error" }));
                let all: Vec<Value> = wrong.chain(syntax).collect();
                let told = json!({ "uri": uri, "diagnostics": all });
                say(json!({ "jsonrpc": "2.0", "method": "textDocument/publishDiagnostics", "params": told }));
                texts.insert(uri, text);
                continue;
            }
            _ if message.get("id").is_none() || method.is_empty() => continue,
            "textDocument/hover" if mode == "silent" => continue,
            "textDocument/hover" if mode == "dies" => std::process::exit(3),
            _ => {}
        }
        let uri = params["textDocument"]["uri"].as_str().unwrap_or_default();
        let text = texts.get(uri).map_or("", String::as_str);
        let answer = answer(method, &params["position"], uri, text);
        say(json!({ "jsonrpc": "2.0", "id": message["id"], "result": answer }));
    }
}

fn answer(method: &str, position: &Value, uri: &str, text: &str) -> Value {
    let (line, character) = (number(&position["line"]), number(&position["character"]));
    let shown: Vec<u16> = text.split('\n').nth(line).unwrap_or_default().encode_utf16().collect();
    let is_word = |unit: &u16| char::from_u32(u32::from(*unit)).is_some_and(|c| c.is_alphanumeric() || c == '_');
    let (before, after) = shown.split_at(character.min(shown.len()));
    let start = before.len() - before.iter().rev().take_while(|unit| is_word(unit)).count();
    let end = before.len() + after.iter().take_while(|unit| is_word(unit)).count();
    let text_of = |units: &[u16]| String::from_utf16(units).expect("a place is no half of a character");
    let place = |character: usize| json!({ "line": line, "character": character });
    let range = |from: usize, to: usize| json!({ "start": place(from), "end": place(to) });
    match method {
        "initialize" => json!({ "capabilities": {} }),
        "textDocument/hover" => {
            let value = format!("{}|{}", text_of(before).trim_start(), text_of(after));
            json!({ "contents": { "kind": "markdown", "value": value }, "range": range(start, end) })
        }
        "textDocument/completion" => {
            let word = text_of(&before[start..]);
            let edit = json!({ "newText": format!("{word}_more"), "range": range(start, before.len()) });
            json!({ "isIncomplete": true, "items": [
                { "label": format!("{word}_more"), "textEdit": edit, "data": { "own": 1 } },
                { "label": "get(…)" },
                { "label": "imported", "additionalTextEdits": [edit] },
            ] })
        }
        "textDocument/definition" => {
            let word = text_of(&shown[start..end]);
            let all = all_of(text, &word);
            all.take(1).map(|range| json!({ "uri": uri, "range": range })).collect()
        }
        "textDocument/signatureHelp" => json!({ "signatures": [{ "label": text_of(before).trim_start() }] }),
        _ => Value::Null,
    }
}

/// Returns the ranges of a word in a text.
fn all_of(text: &str, word: &str) -> impl Iterator<Item = Value> {
    let place = |text: &str, at: usize| {
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap_or_default().encode_utf16().count();
        json!({ "line": line, "character": character })
    };
    let found = text.match_indices(word);
    found.map(move |(at, _)| json!({ "start": place(text, at), "end": place(text, at + word.len()) }))
}

fn number(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap_or_default()).unwrap()
}

fn read(input: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if input.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim().strip_prefix("Content-Length: ") {
            Some(number) => length = number.parse().ok()?,
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    let mut bytes = vec![0; length];
    input.read_exact(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Returns a folder with this test as a tool.
fn tools(mode: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let own = env::current_exe().unwrap();
    let script = match mode {
        "missing" => {
            "#!/bin/sh\necho \"error: Unknown binary 'rust-analyzer'\" >&2\necho more >&2\nexit 1\n".to_owned()
        }
        _ => format!(
            "#!/bin/sh\nexport {MODE}={mode}\nexec '{}' --exact lsp_bodies::tool 3>&1 >/dev/null 2>&1\n",
            own.display()
        ),
    };
    for name in ["rust-analyzer", "clangd"] {
        let path = folder.path().join(name);
        fs::write(&path, &script).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

/// Returns an editor with a program, and a tool that answers in its bodies.
fn editor_with(tools: &OsStr, text: &str) -> Editor {
    let mut editor = Editor::start_with_tools(tools);
    editor.open("Main.lf", text);
    assert_eq!(editor.diagnostics("Main.lf"), json!([]));
    // The first question starts it.
    editor.ask_in("Main.lf", text, "textDocument/hover", "doubled(", 2);
    let told = editor.told("window/");
    assert!(told["message"].as_str().unwrap().ends_with("answers in bodies"), "{told}");
    editor
}

fn range(text: &str, word: &str, at: &str) -> Value {
    let behind = text.find(at).expect("it is there");
    let found = text[behind..].find(word).expect("it is there") + behind;
    all_of(text, word).nth(text[..found].matches(word).count()).unwrap()
}

/// Returns the labels of completions.
fn labels(answer: &Value) -> Vec<&str> {
    answer["items"].as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap()).collect()
}

#[test]
fn a_tool_answers_at_the_places_of_the_program() {
    let tools = tools("answers");
    let mut editor = editor_with(tools.path().as_os_str(), RUST);
    let mut ask = |method: &str, text: &str, behind: usize| {
        editor.ask_in("Main.lf", RUST, &format!("textDocument/{method}"), text, behind)
    };
    let line = "let ü = \"𝄞\"; let gro|wn = doubled(ctx.get(x).unwrap_or_default());";
    let hover = ask("hover", "grown = ", 3);
    assert_eq!(hover["contents"]["value"], line);
    assert_eq!(hover["range"], range(RUST, "grown", "let grown"));
    // Ours is the first part where LF has the name.
    let both = ask("hover", "list.push", 1);
    let both = both["contents"]["value"].as_str().unwrap();
    assert!(both.starts_with("```lf\nstate list") && both.ends_with("self.l|ist.push(grown);"), "{both}");
    assert_eq!(ask("definition", "grown);\n    ctx", 2)[0]["range"], range(RUST, "grown", "let grown"));
    assert_eq!(ask("signatureHelp", "grown);\n    ctx", 0)["signatures"][0]["label"], "self.list.push(");
    let completions = ask("completion", "unwrap_or_default", 6);
    assert_eq!(labels(&completions), ["unwrap_more", "get(…)"]);
    let edit = &completions["items"][0]["textEdit"];
    assert_eq!((&edit["newText"], &edit["range"]), (&json!("unwrap_more"), &range(RUST, "unwrap", "unwrap")));
    // Our own words come first, and one of two names for one thing stays.
    let both = ask("completion", "ctx.set(y, grown", 4);
    let both = labels(&both);
    assert_eq!((both[0], both.last(), both.contains(&"get(…)")), ("get", Some(&"_more"), false));
    // A value is code, too, and a name that LF declares is where LF declares it.
    assert_eq!(ask("hover", "doubled(1)", 0)["range"], range(RUST, "doubled", "doubled(1)"));
    assert_eq!(ask("definition", "y, grown", 0)["range"], range(RUST, "y", "y: u32\n  state"));
    editor.end();
}

#[test]
fn a_body_that_is_no_code_yet_is_read_as_it_stands() {
    let tools = tools("answers");
    let mut editor = editor_with(tools.path().as_os_str(), RUST);
    editor.ask_in("Main.lf", RUST, "textDocument/hover", "grown = ", 0);
    let text = RUST.replace("self.list.push(grown);", "self.list.\n    let WRONG = \"ü\";");
    editor.change("Main.lf", &text);
    assert_eq!(editor.diagnostics("Main.lf")[0]["code"], "E065-code-syntax");
    let told = editor.diagnostics("Main.lf");
    let of_tool: Vec<&Value> = told.as_array().unwrap().iter().filter(|one| one["source"] == "tool").collect();
    assert_eq!(of_tool.len(), 1, "one for both federates, and no errors of syntax: {told:#}");
    assert_eq!(of_tool[0]["range"], range(&text, "WRONG", "WRONG"));
    let hover = editor.ask_in("Main.lf", &text, "textDocument/hover", "list.\n", 5);
    assert!(hover["contents"]["value"].as_str().unwrap().ends_with("self.list.|"), "{hover}");
    let completions = editor.ask_in("Main.lf", &text, "textDocument/completion", "list.\n", 5);
    assert_eq!(
        completions["items"][0]["textEdit"]["range"]["start"],
        editor.place("Main.lf", &text, ".\n", 1)["position"]
    );
    // An empty line at the end of a body is not generated: what fits there is what fits behind the line before.
    let text = RUST.replace("ctx.set(y, grown);\n  =}", "ctx.set(y, grown);\n    \n  =}");
    editor.change("Main.lf", &text);
    let end = editor.ask_in("Main.lf", &text, "textDocument/completion", "grown);\n    \n  =}", 12);
    assert!(labels(&end).contains(&"_more") && labels(&end).contains(&"ctx"), "{end}");
    // With an error outside of bodies there is no code to read, and we answer alone.
    editor.change("Main.lf", &text.replace("sum = new Sum()", "sum = new Sun()"));
    let alone = editor.ask_in("Main.lf", &text, "textDocument/completion", "ctx.set(y, grown", 4);
    assert_eq!(alone[0]["label"], "get");
    editor.change("Main.lf", RUST);
    let hover = editor.ask_in("Main.lf", RUST, "textDocument/hover", "grown = ", 0);
    assert!(hover["contents"]["value"].as_str().unwrap().contains("let |grown"), "{hover}");
    editor.end();
}

#[test]
fn a_tool_of_c_answers_at_the_places_of_the_program() {
    let tools = tools("answers");
    let mut editor = editor_with(tools.path().as_os_str(), C);
    let hover = editor.ask_in("Main.lf", C, "textDocument/hover", "doubled(7)", 3);
    assert_eq!(hover["contents"]["value"], "int ü = 3; self->last = dou|bled(7);");
    assert_eq!(hover["range"], range(C, "doubled", "doubled(7)"));
    let inside = editor.ask_in("Main.lf", C, "textDocument/completion", "lf_print", 3);
    let more = inside["items"].as_array().unwrap().iter().find(|item| item["label"] == "lf__more").unwrap();
    assert_eq!(more["textEdit"]["range"], range(C, "lf_", "lf_print"));
    let text = C.replace("doubled(7);", "WRONG");
    editor.change("Main.lf", &text);
    assert_eq!(editor.diagnostics("Main.lf"), json!([]));
    assert_eq!(editor.diagnostics("Main.lf")[0]["range"], range(&text, "WRONG", "WRONG"));
    editor.end();
}

#[test]
fn without_a_tool_we_answer_alone_and_say_what_to_install() {
    let tools = tools("missing");
    for path in [tools.path(), Path::new("/nowhere")] {
        let mut editor = Editor::start_with_tools(path.as_os_str());
        editor.open("Main.lf", RUST);
        let own = editor.ask_in("Main.lf", RUST, "textDocument/hover", "list.push", 1);
        assert!(own["contents"]["value"].as_str().unwrap().starts_with("```lf\nstate list"), "{own}");
        let told = editor.told("window/showMessage")["message"].as_str().unwrap().to_owned();
        assert!(told.starts_with("rust-analyzer does not run (") && told.contains("`rustup component add"), "{told}");
        assert_eq!(told.contains("Unknown binary"), path != Path::new("/nowhere"), "{told}");
        assert_eq!(editor.ask_in("Main.lf", RUST, "textDocument/hover", "grown = ", 1), Value::Null);
        assert_eq!(editor.ask_in("Main.lf", RUST, "textDocument/hover", "grown = ", 2), Value::Null);
        assert_eq!(editor.heard.iter().filter(|method| *method == "window/showMessage").count(), 1);
        editor.end();
    }
}

#[test]
fn a_tool_that_is_silent_or_dies_keeps_nobody_waiting() {
    for mode in ["silent", "dies"] {
        let tools = tools(mode);
        let mut editor = editor_with(tools.path().as_os_str(), RUST);
        let own = editor.ask_in("Main.lf", RUST, "textDocument/hover", "list.push", 1);
        assert!(own["contents"]["value"].as_str().unwrap().starts_with("```lf\nstate list"), "{own}");
        if mode == "dies" {
            let told = editor.told("window/showMessage")["message"].as_str().unwrap().to_owned();
            assert!(told.starts_with("rust-analyzer does not run, so lfz answers alone"), "{told}");
        }
        editor.end();
    }
}

/// Returns the folders of programs, if a tool there can be run.
fn path_with(tool: &str) -> Option<PathBuf> {
    let runs = |path: &PathBuf| Command::new(path).arg("--version").output().is_ok_and(|it| it.status.success());
    let found = env::split_paths(&env::var_os("PATH")?).map(|folder| folder.join(tool)).find(runs);
    if found.is_none() {
        println!("skipped: {tool} is not installed");
    }
    found
}

/// Asks until a real tool answers: it reads much at first, and may take longer than the server waits.
fn ask_tool(editor: &mut Editor, text: &str, method: &str, word: &str, behind: usize) -> Value {
    for _ in 0..300 {
        let answer = editor.ask_in("Main.lf", text, &format!("textDocument/{method}"), word, behind);
        let is_ours = answer.is_null() || (method == "completion" && answer.is_array());
        if !is_ours {
            return answer;
        }
    }
    panic!("the tool never answers {method} at {word}");
}

/// Returns the next diagnostics of the program that are not none.
fn found(editor: &mut Editor) -> Value {
    loop {
        let told = editor.diagnostics("Main.lf");
        if told != json!([]) {
            return told;
        }
    }
}

#[test]
fn clangd_knows_the_bodies_of_c() {
    if path_with("clangd").is_none() {
        return;
    }
    let mut editor = editor_with(&env::var_os("PATH").unwrap(), C);
    let hover = ask_tool(&mut editor, C, "hover", "doubled(7)", 3);
    assert!(hover["contents"]["value"].as_str().unwrap().contains("int number"), "{hover}");
    let defined = ask_tool(&mut editor, C, "definition", "doubled(7)", 3);
    assert_eq!(defined[0]["range"], range(C, "doubled", "doubled(int"), "{defined}");
    let signature = ask_tool(&mut editor, C, "signatureHelp", "7);", 0);
    assert_eq!(signature["signatures"][0]["label"], "doubled(int number) -> int", "{signature}");
    let text = C.replace("doubled(7);", "doubled(sq);");
    editor.change("Main.lf", &text);
    let completions = ask_tool(&mut editor, &text, "completion", "sq);", 2);
    assert!(labels(&completions).iter().any(|label| label.trim().starts_with("sqrt(")), "{completions}");
    let text = C.replace("doubled(7);", "doubled(seven);");
    editor.change("Main.lf", &text);
    // The errors of the text before may come first.
    let wrong = loop {
        let wrong = found(&mut editor);
        if wrong[0]["message"].as_str().unwrap().contains("seven") {
            break wrong;
        }
    };
    assert_eq!(wrong[0]["range"], range(&text, "seven", "seven"), "{wrong}");
    editor.end();
}

#[test]
fn rust_analyzer_knows_the_bodies_of_rust() {
    if path_with("rust-analyzer").is_none() {
        return;
    }
    let mut editor = editor_with(&env::var_os("PATH").unwrap(), RUST);
    let defined = ask_tool(&mut editor, RUST, "definition", "doubled(ctx", 3);
    assert_eq!(defined[0]["range"], range(RUST, "doubled", "fn doubled"), "{defined}");
    let hover = ask_tool(&mut editor, RUST, "hover", "grown = ", 1);
    assert!(hover["contents"]["value"].as_str().unwrap().contains("let grown: u32"), "{hover}");
    let signature = ask_tool(&mut editor, RUST, "signatureHelp", "ctx.get(x)", 0);
    assert_eq!(signature["signatures"][0]["label"], "fn doubled(number: u32) -> u32", "{signature}");
    let text = RUST.replace("self.list.push(grown);", "let fast = Fast { speed: self.first }; fast.");
    editor.change("Main.lf", &text);
    let completions = ask_tool(&mut editor, &text, "completion", "fast.", 5);
    assert!(labels(&completions).contains(&"speed"), "{completions}");
    editor.end();
}
