# SPDX-License-Identifier: Apache-2.0
"""The command line of the evaluation, results.json, and the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from lf_evaluate import page
from lf_evaluate.figures import stacked
from lf_evaluate.main import PARTS, main

# As the first version of the program wrote it.
# fmt: off
LINE = {"label": "solid & whole", "who": "ours", "line": "solid", "points": [[1.0, 0.0], [10.0, 50.0], [100.0, 100.0]]}
DELAY = {"label": "delay in µs", "is_logarithmic": True}
MARKS = [{"label": "thesis: 4 ms & more", "who": "thesis", "at": 40.0}]
FIGURES: list[Any] = [
    {"title": title, "thesis": "figure 6.6", "caption": "A <caption>.", "plot": {title: plot}} for title, plot in {
        "rows": {"axis": DELAY, "marks": MARKS, "rows": [
            {"label": "ours <fast> $1$", "who": "ours", "values": [30.0, 40.0, 35.0]},
            {"label": "nothing measured", "who": "stock", "values": []},
        ]},
        "curves": {"x": DELAY, "y": {"label": "messages in %", "is_logarithmic": False}, "marks": MARKS, "curves": [
            LINE, {**LINE, "label": "dashed", "line": "dashed"}, {**LINE, "label": "", "line": "points", "points": []},
        ]},
        "stacked": {"axis": {"label": "KiB", "is_logarithmic": False}, "parts": ["Zephyr", "<ours>"],
                    "bars": [["sender", [61.3, 12.0]], ['unit "B"', [61.3, 0.0]]]},
    }.items()
]
NUMBER = {"value": 30.0, "digits": 1, "rounds": [30.0, 35.5]}
FINDING = {
    "title": "Latency & <more>", "question": "How long?", "method": ["In turns."], "figures": FIGURES,
    "compared": [{"what": "median", "unit": "µs", "less_is_better": True, "ours": NUMBER, "with": "stock RTI",
                  "theirs": {"value": 60.0, "digits": 1}}],
    "tables": [{"title": "Numbers", "headings": ["", "ours", "stock RTI"],
                "rows": [["median <µs>", NUMBER, "cannot be started"]]}],
    "limits": ["Not the same boards."],
}
RESULTS = {
    "format": 1, "begun": "2026-01-02 03:04 UTC", "quick": True,
    "arguments": ["--repository", "/r", "--lfz", "/l", "--quick"],
    "machine": {"processor": "A processor", "cores": 2, "memory_gib": 23.5, "kernel": "6.1", "governor": None,
                "virtualized_by": "kvm", "load": 0.25,
                "versions": [{"name": "lf-zephyr-rs", "version": "abc of 2026-01-01"}]},
    "parts": [
        {"name": "latency", "seconds": 1.5, "outcome": {"measured": FINDING}},
        {"name": "rate", "seconds": 1.5, "outcome": {"failed": "<script>alert(1)</script> is not found"}},
        {"name": "sizes", "seconds": 1.5, "outcome": {"skipped": "there is no Zephyr workspace"}},
    ],
}
# fmt: on


@pytest.fixture
def libraries() -> None:
    """Skip without the libraries for the page, which only some users install."""
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with an lf-bench that measures clocks, and fails at everything else."""
    monkeypatch.delenv("ZEPHYR_BASE", raising=False)
    lines = [
        {"row": "quiet, on", "who": who, "unit": "median µs", "value": value}
        for who, value in (("ours", 2.0), ("stock algorithm", 8.0))
    ]
    look = {"row": "offset", "unit": "offset µs", "value": 26.0, "samples": [0.0, 26.0]}
    text = "\n".join(json.dumps(line) for line in [*lines, {**look, "who": "init"}, {**look, "who": "on"}])
    bench = tmp_path / "lf-bench"
    bench.write_text(
        f"#!/bin/sh\n[ $1 = clock ] || {{ echo 'error: lfz rti is gone' >&2; exit 1; }}\ncat <<E\n{text}\nE\n"
    )
    bench.chmod(0o755)
    return tmp_path


@pytest.mark.usefixtures("libraries")
@pytest.mark.parametrize(
    ("figure", "labels"),
    [
        (FIGURES[0], ["ours <fast> $1$", "nothing measured (none)", "delay in µs", "thesis: 4 ms & more"]),
        (FIGURES[1], ["solid & whole", "dashed", "delay in µs", "messages in %", "thesis: 4 ms & more"]),
        (FIGURES[2], ["sender", 'unit "B"', "Zephyr", "<ours>", "KiB", "73.3", "61.3"]),
    ],
)
def test_each_drawing_is_xml_with_all_of_its_labels(figure: Any, labels: list[str]) -> None:
    texts = {(text or "").strip() for text in ElementTree.fromstring(page.draw(figure)).itertext()}
    assert not set(labels) - texts


@pytest.mark.usefixtures("libraries")
def test_a_single_bar_leaves_room_for_the_names_of_its_parts() -> None:
    names = [f"part {number}" for number in range(9)]
    bar = stacked("Code", "", "KiB", names, {"one image": [1.0] * 9})
    # matplotlib warns where there is no room, and warnings are errors here.
    assert page.draw(bar).count("part ") == 9


@pytest.mark.usefixtures("libraries")
def test_the_page_of_old_results_needs_nothing_else_and_escapes_what_it_is_told(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    file.write_text(json.dumps(RESULTS))
    assert main([str(tmp_path), "--report", str(tmp_path / "new"), "--from", str(file)]) == 0
    text = (tmp_path / "new/report.html").read_text()
    for words in (
        "Latency &amp; &lt;more&gt;",
        "&lt;script&gt;alert(1)&lt;/script&gt; is not found",
        "2 × better",
        "A quick run",
        "This part failed",
        "This part was left out: there is no Zephyr workspace",
        "--quick</code>",
        "Not the same boards.",
        "abc of 2026-01-01",
    ):
        assert words in text
    # The names of namespaces are no addresses to fetch.
    addresses = text.replace("http://www.w3.org/", "")
    assert not any(word in addresses for word in ("<script", "://", "@import", "url(http"))
    assert text.count("<svg") == 3
    for anchor in ("overview", "latency", "rate", "sizes", "limits", "how"):
        assert f'href="#{anchor}"' in text
        assert f'id="{anchor}"' in text


@pytest.mark.usefixtures("libraries")
def test_results_from_which_something_is_missing_are_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "results.json"
    for results in ({"format": 1}, {**RESULTS, "parts": [{"name": "latency"}]}, {**RESULTS, "parts": 1}):
        file.write_text(json.dumps(results))
        assert main([str(tmp_path), "--report", str(tmp_path / "new"), "--from", str(file)]) == 1
        assert "error: these results are not whole" in capfd.readouterr().err


@pytest.mark.usefixtures("libraries")
def test_a_report_has_what_was_measured_what_failed_and_what_was_left_out(
    built: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    report = built / "report"
    only = [word for part in ("clock", "latency", "sizes") for word in ("--only", part)]
    assert main([str(built), "--quick", "--report", str(report), *only]) == 1
    said = capfd.readouterr()
    assert "[1/3] latency, then clock, sizes\n" in said.err
    assert "error: latency: " in said.err
    assert "lfz rti is gone" in said.err
    assert said.err.endswith("error: failed: latency\n")
    assert "| quiet, on, ours, median | µs   | 2    | 8      | stock algorithm | 4 × better |" in said.out
    assert "sizes is left out: there is no Zephyr workspace" in said.out
    results = json.loads((report / "results.json").read_text())
    assert [(part["name"], *part["outcome"]) for part in results["parts"]] == [
        ("latency", "failed"),
        ("clock", "measured"),
        ("sizes", "skipped"),
    ]
    assert results["arguments"] == ["--quick", "--report", str(report), *only]
    again = built / "again"
    assert main([str(built), "--report", str(again), "--from", str(report / "results.json")]) == 0
    assert (again / "report.html").read_text() == (report / "report.html").read_text()
    assert "thesis, figure 6.3" in (again / "report.html").read_text()


def test_a_part_that_fails_unexpectedly_is_not_the_end_of_the_others(
    built: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (built / "lf-bench").write_text("#!/bin/sh\nexit 0\n")
    assert main([str(built), "--only", "clock", "--only", "large"]) == 1
    said = capfd.readouterr()
    assert "error: clock: KeyError('init')" in said.err
    assert "A large federation" in said.out


def test_a_report_without_its_libraries_says_what_to_install_before_it_measures(
    built: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(page, "find_spec", lambda _: None)
    assert main([str(built), "--only", "clock", "--report", str(built / "report")]) == 1
    said = capfd.readouterr()
    assert "python3 -m pip install matplotlib Jinja2" in said.err
    assert not said.out
    assert main([str(built), "--only", "clock"]) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--only", "weather"], "choose from 'engine', 'suite', 'latency'"),
        (["--only", "pins"], "--only pins needs --recording RECORDING"),
        (["--only", "suite"], "--only suite needs --benchmarks BENCHMARKS"),
        (["--only", "suite", "--benchmarks", "."], "name a clone of LF's benchmarks-lingua-franca"),
        (["--only", "pins", "--recording", "nothing"], "cannot be started: No such file"),
        (["--from", "results.json"], "--from needs --report FOLDER"),
        (["--large", "1"], "'1' is no number from 2 on"),
        (["--rounds", "many"], "'many' is no number from 1 on"),
    ],
)
def test_wrong_arguments_say_what_would_be_right(
    arguments: list[str], words: str, built: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main([str(built), *arguments])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status != 0
    assert words in capfd.readouterr().err


@pytest.mark.usefixtures("libraries")
def test_a_folder_that_cannot_be_written_to_is_refused_before_anything_is_measured(
    built: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for folder in (str(built / "lf-bench"), "/proc/report"):
        assert main([str(built), "--only", "clock", "--report", folder]) == 1
        said = capfd.readouterr()
        assert "name a folder that you may write to" in said.err
        assert not said.out


def test_the_help_names_all_parts(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capfd.readouterr().out
    assert all(f"\n  {part} " in text for part in PARTS)
