// SPDX-License-Identifier: Apache-2.0
//! The JSON file and the page: of results that are made here, and of the program itself.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use lf_bench::page::{draw, render};
use lf_bench::results::{
    Axis, Cell, Comparison, Curve, FORMAT, Figure, Finding, Line, Machine, Mark, Outcome, Part, Plot, Results, Row,
    Table, Version, Who,
};

fn figure(title: &str, plot: Plot) -> Figure {
    Figure { title: title.to_owned(), thesis: "figure 6.6".to_owned(), caption: "A <caption>.".to_owned(), plot }
}

fn figures() -> Vec<Figure> {
    let marks = vec![Mark { label: "thesis: 4 ms & more".to_owned(), who: Who::Thesis, at: 4000.0 }];
    let curve = |label: &str, line, points: &[[f64; 2]]| Curve {
        label: label.to_owned(),
        who: Who::Ours,
        line,
        points: points.to_vec(),
    };
    let rows = vec![
        Row::new("ours <fast>", Who::Ours, vec![30.0, 40.0, 35.0]),
        Row::new("nothing measured", Who::Stock, Vec::new()),
    ];
    let curves = vec![
        curve("solid & whole", Line::Solid, &[[1.0, 0.0], [10.0, 50.0], [100.0, 100.0]]),
        curve("dashed", Line::Dashed, &[[2.0, 0.0], [200.0, 100.0]]),
        curve("points", Line::Points, &[[3.0, 20.0]]),
        curve("empty", Line::Solid, &[]),
    ];
    let (x, y) = (Axis::logarithmic("delay in µs"), Axis::linear("messages in %"));
    let bars = vec![("sender".to_owned(), vec![61.3, 12.0]), ("unit \"B\"".to_owned(), vec![61.3, 0.0])];
    let parts = vec!["Zephyr".to_owned(), "<ours>".to_owned()];
    vec![
        figure("Rows", Plot::Rows { axis: x.clone(), rows, marks: marks.clone() }),
        figure("Curves", Plot::Curves { x, y, curves, marks }),
        figure("Stacked", Plot::Stacked { axis: Axis::linear("KiB"), parts, bars }),
    ]
}

fn results() -> Results {
    let mut table = Table::new("Numbers", ["", "ours", "stock RTI"]);
    table.row(vec!["median <µs>".into(), Cell::least(&[30.0, 35.5], 1), "cannot be started".into()]);
    table.row(vec!["99 %".into(), Cell::count(12_345)]);
    let finding = Finding {
        title: "Latency & <more>".to_owned(),
        question: "How long?".to_owned(),
        method: vec!["In turns.".to_owned()],
        compared: vec![Comparison {
            what: "median".to_owned(),
            unit: "µs".to_owned(),
            less_is_better: true,
            ours: Cell::least(&[30.0, 35.5], 1),
            with: "stock RTI".to_owned(),
            theirs: Cell::number(60.0, 1),
        }],
        tables: vec![table],
        figures: figures(),
        limits: vec!["Not the same boards.".to_owned()],
    };
    let part = |name: &str, outcome| Part { name: name.to_owned(), seconds: 1.5, outcome };
    Results {
        format: FORMAT,
        begun: "2026-01-02 03:04 UTC".to_owned(),
        quick: true,
        arguments: ["--repository", "/r", "--lfz", "/l", "--quick"].map(str::to_owned).to_vec(),
        machine: Machine {
            processor: "A processor".to_owned(),
            cores: 2,
            memory_gib: 23.5,
            kernel: "6.1".to_owned(),
            governor: None,
            virtualized_by: Some("kvm".to_owned()),
            load: 0.25,
            versions: vec![Version { name: "lf-zephyr-rs".to_owned(), version: "abc of 2026-01-01".to_owned() }],
        },
        parts: vec![
            part("latency", Outcome::Measured(finding)),
            part("rate", Outcome::Failed("<script>alert(1)</script> is not found".to_owned())),
            part("sizes", Outcome::Skipped("there is no Zephyr workspace".to_owned())),
        ],
    }
}

#[test]
fn results_survive_as_json() {
    let mut results = results();
    let text = serde_json::to_string_pretty(&results).expect("it has no maps");
    assert_eq!(serde_json::from_str::<Results>(&text).expect("it was written so"), results);
    // The figures are long, and say nothing new about the format.
    if let Outcome::Measured(finding) = &mut results.parts[0].outcome {
        finding.figures.truncate(1);
    }
    insta::assert_snapshot!(serde_json::to_string_pretty(&results).expect("it has no maps"));
}

#[test]
fn what_is_printed_is_what_is_in_the_results() {
    let results = results();
    let Outcome::Measured(finding) = &results.parts[0].outcome else { panic!("it was measured") };
    insta::assert_snapshot!(finding);
}

#[test]
fn each_drawing_is_xml_with_all_of_its_labels() {
    for (figure, labels) in figures().iter().zip([
        vec!["ours <fast>", "nothing measured", "none", "35 (30–40)", "delay in µs", "thesis: 4 ms & more"],
        vec!["solid & whole", "dashed", "points", "delay in µs", "messages in %", "thesis: 4 ms & more"],
        vec!["sender", "unit \"B\"", "Zephyr", "<ours>", "KiB", "73.3", "61.3"],
    ]) {
        let drawing = draw(figure).expect("it can be drawn");
        let document = roxmltree::Document::parse(&drawing).expect("it is XML");
        let texts: Vec<_> = document
            .descendants()
            .filter(roxmltree::Node::is_text)
            .filter_map(|node| node.text())
            .map(str::trim)
            .collect();
        for label in labels {
            assert!(texts.contains(&label), "{label} is not in {texts:?}");
        }
    }
}

#[test]
fn the_page_needs_nothing_else_and_escapes_what_it_is_told() {
    let page = render(&results()).expect("all can be drawn");
    assert!(page.contains("Latency &amp; &lt;more&gt;"));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt; is not found"));
    assert!(!page.contains("<script"));
    // The name of a namespace is no address that anybody asks.
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("://") && !addresses.contains("@import") && !addresses.contains("url("), "{addresses}");
    for words in [
        "2 × better",
        "30.0",
        "A quick run",
        "This part failed",
        "This part was left out: there is no Zephyr workspace",
        "What cannot be compared, and why",
        "cargo xtask evaluate --quick<",
        "Not the same boards.",
        "abc of 2026-01-01",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert_eq!(page.matches("<svg").count(), 3);
    for id in ["overview", "latency", "rate", "sizes", "limits", "how"] {
        assert!(page.contains(&format!("href=\"#{id}\"")) && page.contains(&format!("id=\"{id}\"")), "{id}");
    }
}

fn bench(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lf-bench"));
    command.env_remove("ZEPHYR_BASE").args(["--lfz", "/nowhere/lfz", "--repository", env!("CARGO_MANIFEST_DIR")]);
    command.args(arguments).output().expect("it was built")
}

fn path(path: &Path) -> &str {
    path.to_str().expect("temporary folders are text")
}

#[test]
fn a_report_has_what_was_measured_what_failed_and_what_was_left_out() {
    let folder = tempfile::tempdir().expect("there is room");
    let report = folder.path().join("report");
    let parts = ["--only", "clock", "--only", "latency", "--only", "sizes"];
    let output = bench(&[&["--quick", "--report", path(&report)], &parts[..]].concat());
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(!output.status.success(), "a part has failed: {errors}");
    assert!(errors.contains("[1/3] latency, about ") && errors.contains("[3/3] sizes, about "), "{errors}");
    assert!(errors.contains("error: latency: lfz rti cannot be started"), "{errors}");
    assert!(said.contains("| quiet, on ") && said.contains("sizes is left out: there is no Zephyr"), "{said}");

    let text = fs::read_to_string(report.join("results.json")).expect("it was written");
    let results: Results = serde_json::from_str(&text).expect("it is whole");
    let names: Vec<_> = results.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["latency", "clock", "sizes"]);
    assert!(matches!(&results.parts[0].outcome, Outcome::Failed(error) if error.contains("cannot be started")));
    assert!(matches!(&results.parts[1].outcome, Outcome::Measured(finding) if finding.figures.len() == 1));
    assert!(matches!(&results.parts[2].outcome, Outcome::Skipped(_)));
    let page = fs::read_to_string(report.join("report.html")).expect("it was written");
    assert!(page.contains("thesis, figure 6.3") && page.contains("This part failed"));

    let again = folder.path().join("again");
    let from = report.join("results.json");
    assert!(bench(&["--report", path(&again), "--from", path(&from)]).status.success());
    assert_eq!(fs::read_to_string(again.join("report.html")).expect("it was written"), page);
}

#[test]
fn wrong_arguments_say_what_would_be_right() {
    let folder = tempfile::tempdir().expect("there is room");
    let file = folder.path().join("file");
    fs::write(&file, "{\"format\": 0}").expect("there is room");
    let refused = |arguments: &[&str], words: &str| {
        let output = bench(arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && errors.contains(words), "{arguments:?}: {errors}");
    };
    refused(&["--only", "weather"], "possible values: latency, throughput");
    refused(&["--only", "clock", "--report", path(&file)], "name a folder that you may write to");
    refused(&["--only", "clock", "--report", "/proc/report"], "name a folder that you may write to");
    refused(&["--from", path(&file)], "--report <FOLDER>");
    let report = path(folder.path());
    refused(&["--report", report, "--from", path(&file)], "it has format 0, and this program reads 1");
    fs::write(&file, "no results").expect("there is room");
    refused(&["--report", report, "--from", path(&file)], "give a results.json that --report has written");
    refused(&["--report", report, "--from", "/nowhere"], "--from /nowhere: No such file");
    refused(&["--only", "pins"], "needs a --recording");
    let output = bench(&["--only", "pins", "--recording", path(&file)]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("error: pins: "), "{output:?}");
}
