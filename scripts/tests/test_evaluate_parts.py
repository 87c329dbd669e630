# SPDX-License-Identifier: Apache-2.0
"""Input of the evaluation's parts: lines of lf-bench, the output of federates, linkers' maps, recordings."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from lf_evaluate import clocks, grid, message, sizes, suite, thesis
from lf_evaluate.measured import Measured, in_turns, percentile, read, spread_out
from lf_evaluate.peers import Lfc
from lf_evaluate.results import Number, compare, finding_text, load, number, range_of, tabulate, value_of, verdict
from lf_evaluate.setting import Setting
from lf_west.errors import LfError
from lf_west.memory import Memory

MAP = """\
Discarded input sections

 .text.gone     0x0000000000000000       0x10 /b/lf/librustapp.a(rustapp.o)

Linker script and memory map

 .text.lf_main  0x0000000000001000       0x20 /b/lf/librustapp.a(rustapp.o)
 .text._RNvMNtNtCsxQLjlM4FvJ_15lf_coordination8federate7running
                0x0000000000001020      0x100 /b/lf/librustapp.a(rustapp.o)
 .text._RINvNtCs1a2B_4core3ptr4dropNtCs3c_8lf_model3TagE
                0x0000000000001120       0x40 /b/lf/librustapp.a(rustapp.o)
 .text.tcp_recv
                0x0000000000002000      0x200 zephyr/subsys/net/ip/libsubsys__net__ip.a(tcp.c.obj)
 .text.main     0x0000000000002200       0x08 app/libapp.a(main.c.obj)
 .rodata.main.str1.1
                0x0000000000003000       0x30 app/libapp.a(main.c.obj)
                                         0x38 (size before relaxing)
 .bss.lost      0x0000000020000000       0x08 modules/lf-zephyr-rs/lib..__zephyr.a(fatal.c.obj)
 .debug_info    0x0000000000000000     0x1000 app/libapp.a(main.c.obj)
 *fill*         0x0000000020000008        0x4
"""
CONFIG = "CONFIG_LF_RTI=y\nCONFIG_MAIN_STACK_SIZE=8192\nCONFIG_LF_RTI_STACK_SIZE=4096\n"
FAR, NEAR = [Measured("delay", who, "µs") for who in ("stock RTI", "lfz rti")]


def setting(built: Path, recording: Path | None = None) -> Setting:
    numbers = dict.fromkeys(
        ("rounds", "exchanges", "seconds", "large", "large_seconds", "iterations", "after_runs", "drift_seconds"), 2
    )
    return Setting(
        built=built,
        stock_rti=None,
        lfc=None,
        reactor_rs=None,
        benchmarks=None,
        quick=True,
        recording=recording,
        has_zephyr=False,
        **numbers,
    )


def test_a_line_of_lf_bench_is_a_value_samples_or_an_error() -> None:
    lines = (
        '{"part":"latency","row":"delay","who":"lfz rti","unit":"µs","value":2.5,"samples":[1,4]}\n'
        '{"part":"latency","row":"delay","who":"stock RTI","unit":"","error":"it cannot be started"}\n'
    )
    assert read(lines) == [
        replace(NEAR, value=2.5, samples=(1.0, 4.0)),
        replace(FAR, unit="", error="it cannot be started"),
    ]
    for wrong in ("warning: this is no JSON", '{"row":"delay"}', "[1]"):
        with pytest.raises(LfError, match="lf-bench printed what is no measurement"):
            read(wrong)


def test_percentiles_are_samples() -> None:
    samples = tuple(float(value) for value in range(200, 0, -1))
    assert [percentile(samples, percent) for percent in (0, 50, 99, 100)] == [1, 100, 198, 200]
    spread = spread_out([replace(NEAR, samples=samples), FAR], {"median": 50, "99 %": 99})
    assert [(one.unit, one.value) for one in spread] == [("median µs", 100), ("99 % µs", 198)]


def test_the_best_round_counts_and_all_are_kept_and_an_error_stands_in_its_place() -> None:
    rates = [Measured("16, 1", "lfz rti", "messages/s", value) for value in (12345.5, 13000.25)]
    seen = [*rates, Measured("16, 1", "stock RTI", "", error="it cannot be started")]
    table = tabulate([*seen, replace(NEAR, value=35.25), replace(NEAR, value=30.0)], "federates")
    assert table["headings"] == ["federates", "lfz rti: messages/s", "lfz rti: µs", "stock RTI"]
    assert table["rows"][0] == ["16, 1", number(13000.25, [12345.5, 13000.25]), "", "it cannot be started"]
    cell = table["rows"][1][2]
    assert (value_of(cell), range_of(cell)) == ("30.0", "30.0–35.2")
    assert value_of(number(12_345)) == "12,345"


def test_numbers_whose_rounds_overlap_are_not_told_apart() -> None:
    def said(ours: list[float], theirs: list[float], unit: str = "µs") -> str:
        values = [replace(NEAR, unit=unit, value=value) for value in ours]
        (one,) = compare([*values, *(replace(FAR, unit=unit, value=value) for value in theirs)], ["lfz rti"], [unit])
        return verdict(one)[1]

    assert said([30, 40], [35]) == "within the spread"
    assert said([30], [60]) == "2 × better"
    assert said([30], [60], "messages/s") == "2 × worse"
    assert said([30], [31]) == "about equal"
    assert said([1], [20_000]) == "over 10,000 × better"


def test_results_are_read_from_what_federates_print() -> None:
    rate = message.rate_in("row", "Linux", "b | received 2999 of 3000 messages in order, 9938 messages per second\n")
    assert [(one.unit, one.value) for one in rate] == [("messages/s", 9938), ("received", 2999)]
    received = [f"receiver{index} | received 3 of 3 messages in 1000000 ns\n" for index in range(2)]
    assert message.flow_in("".join(received), 2) == 4000
    for wrong in (received[0], f"{received[0]}received 2 of 3 messages in 1000000 ns\n"):
        with pytest.raises(LfError):
            message.flow_in(wrong, 2)
    assert message.delays_in("delays | delay 1500 ns\ndelays | delayed\n") == (1.5,)
    medians = {"federates": 120, "raw": 80}
    said = [f"asker | {who}: 5 messages, delay in us: median {it}, p99 9, max 9" for who, it in medians.items()]
    delays = message.board_delays_in("row", "\n".join(said))
    assert [(one.who, one.value) for one in delays[::2]] == [("federates", 120), ("raw TCP", 80)]
    for reads in (message.delays_in, clocks.drift_in, lambda text: message.rate_in("", "", text)):
        with pytest.raises(LfError, match="there is no result in what was printed:\nnothing"):
            reads("nothing")
    drifted = clocks.drift_in("board    | sent 900, heard 899, 1 late, the slowest after 812 us")
    assert [one.value for one in drifted] == [900, 899, 1, 812]


def test_a_run_of_the_grid_is_violated_when_a_unit_is_late_or_silent() -> None:
    both = "b   | B: open, reaction time 25.22 ms\nc   | C: open, reaction time 26.5 ms\n"
    assert grid.run_in(both) == grid.GridRun({"B": 25.22, "C": 26.5}, False)
    assert grid.run_in(both + "c | 1 late message\n").is_violated
    assert grid.run_in("a   | A: closed, reaction time 25.19 ms\n") == grid.GridRun({}, True)
    assert [len(units) for units in thesis.REACTIONS.values()] == [2, 2, 2]


def test_only_what_is_ours_and_in_the_image_counts() -> None:
    kinds, code = sizes.shares(MAP)
    assert kinds == {"text": 0x168, "rodata": 0x30, "bss": 8}
    assert code == {"other crates": 0x20, "coordination": 0x100, "model": 0x40, "C": 8}


def test_an_rti_beside_a_federate_has_a_stack_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "measure", lambda _: Memory(2048, 1024))
    (tmp_path / "zephyr").mkdir()
    (tmp_path / "zephyr/zephyr.map").write_text(MAP.replace(" 0x08 modules", " 0x1008 modules"))
    for config, stacks, bss in ((CONFIG, 8192, 0x1008), (CONFIG + "CONFIG_LF_FEDERATE=y\n", 12_288, 8)):
        (tmp_path / "zephyr/.config").write_text(config)
        image = sizes.image_in(tmp_path, "rti", Memory(0, 0))
        assert (image.stacks, image.share["bss"]) == (stacks, bss)


def test_the_parts_of_a_bar_are_the_whole_image() -> None:
    kib = 1024
    share = Counter(text=24 * kib, rodata=8 * kib, data=kib, bss=512)
    code = Counter(dict.fromkeys(sizes.PARTS, kib))
    image = sizes.Image("sender", Memory(100 * kib, 30 * kib), Memory(60 * kib, 28 * kib), share, code, 8 * kib)
    finding = sizes.of_images([image])
    cells = [value_of(cell) for cell in finding["tables"][0]["rows"][0]]
    assert cells == ["sender", "100.0", "30.0", "60.0", "28.0", "24.0", "8.0", "1.0", "0.5", "8.0", "33.0", "9.5"]
    assert finding["figures"][0]["plot"]["stacked"]["bars"] == [["sender", [60.0, 7.0, 24.0, 8.0, 1.0]]]
    assert "| sender | 100.0 | 30.0 |" in finding_text(finding)


def test_pins_of_two_participants_are_compared_from_the_first_edge_on(tmp_path: Path) -> None:
    assert clocks.two_of(["a.led0", "a.led1", "b.led0"]) == ("a.led0", "b.led0")
    assert clocks.two_of(["logic.D0", "logic.D1"]) == ("logic.D0", "logic.D1")
    with pytest.raises(LfError, match="fewer than two pins"):
        clocks.two_of(["a.led0"])
    lfz = tmp_path / "lfz"
    lfz.write_text(
        """#!/bin/sh
case "$*" in
*--reference\\ a.led0\\ --compare\\ b.led0*) echo '{ "reference": "a.led0", "compared": [{ "signal": "b.led0",
  "delay": { "min_us": -30.0, "max_us": 22.0 }, "drift": { "slope_us_per_s": 26.0, "offset_us": -56.0 },
  "pairs": [{ "time_ns": 1e9, "delay_ns": -3e4 }, { "time_ns": 3e9, "delay_ns": 2.2e4 }] }] }' ;;
*) echo '{ "signals": [{ "signal": "a.led0" }, { "signal": "b.led0" }] }' ;;
esac
"""
    )
    lfz.chmod(0o755)
    finding = clocks.pins(setting(tmp_path, tmp_path / "pins.vcd"))
    assert [value_of(cell) for cell in finding["tables"][0]["rows"][0]] == ["init", "2", "-30", "26", "30", "26"]
    points = finding["figures"][0]["plot"]["curves"]["curves"][0]["points"]
    assert points == [[0.0, -30.0], [2.0, 22.0]]


def test_results_of_another_format_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    for text, words in (
        ('{"format": 0}', "it has format 0, and this program reads 1"),
        ("no results", "give a results.json that --report has written"),
        ("[]", "give a results.json that --report has written"),
    ):
        file.write_text(text)
        with pytest.raises(LfError, match=words):
            load(file)
    with pytest.raises(LfError, match="No such file"):
        load(tmp_path / "nothing")
    assert Number(value=1.0, digits=0, rounds=[]) == number(1)


C_BENCHMARK = """\
target C {
  /* [[[cog
        cog.outl("single-threaded: true,")
  ]]] */ // keep-format
  single-threaded: true,
  fast: true
}
/*[[[cog
cog.outl(f'main reactor PingPong(numIterations:size_t={numIterations}, count:size_t={count})')
]]] */
main reactor PingPong(numIterations:size_t=12, count:size_t=1000000) {
    runner = new BenchmarkRunner(num_iterations=numIterations);
}
"""
RUST_BENCHMARK = """\
target Rust {
  build-type: Release,
  cargo-features: ["cli"]
}
reactor Runner(num_iterations: usize = 12) {}
main reactor(num_iterations: usize = 12, count: usize = 40000) {}
"""


def test_benchmarks_get_iterations_and_workers_and_keep_the_rest() -> None:
    def lines(text: str, target: str, workers: int, lfc: Lfc | None) -> list[str]:
        benchmark = suite.Benchmark(target, Path("micro/PingPong.lf"), workers)
        changed = suite.changed(text, benchmark, 5, lfc).splitlines()
        return [line for line in changed if line.strip() and line not in text.splitlines()]

    lfc = Lfc(Path("lfc"), Path("/r"), None)
    main = "main reactor PingPong(numIterations:size_t=5, count:size_t=1000000) {"
    single = "target C { build-type: Release, single-threaded: true,"
    assert lines(C_BENCHMARK, "C", 0, None) == lines(C_BENCHMARK, "C", 0, lfc) == [single, main]
    assert lines(C_BENCHMARK, "C", 2, None) == ["target C { build-type: Release, workers: 2,", main]
    main = "main reactor(num_iterations: usize = 5, count: usize = 40000) {}"
    ours = 'target Rust { build-type: Release, workers: 1, edition: "2021", logging: warn,'
    assert lines(RUST_BENCHMARK, "Rust", 1, None) == [ours, main]
    theirs = 'target Rust { build-type: Release, external-runtime-path: "/r"'
    assert lines(RUST_BENCHMARK, "Rust", 0, lfc) == [f"{theirs}, single-threaded: true,", main]
    assert lines(RUST_BENCHMARK, "Rust", 1, lfc) == [f"{theirs}, workers: 1,", main]
    with pytest.raises(LfError, match="is the number of iterations"):
        lines("target C {\n}\nmain reactor {}\n", "C", 0, None)


def test_benchmarks_are_those_with_a_main_reactor_and_parallel_ones_get_workers(tmp_path: Path) -> None:
    for name, text in {
        "C/Savina/src/BenchmarkRunner.lf": "target C\nreactor BenchmarkRunner {}\n",
        "C/Savina/src/micro/PingPong.lf": C_BENCHMARK,
        "Rust/Savina/src/parallelism/MatMul.lf": RUST_BENCHMARK,
    }.items():
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    rows = [it.row for it in suite.benchmarks_in(tmp_path, False)]
    assert rows == ["C PingPong", "Rust MatMul", "Rust MatMul, 1 worker", "Rust MatMul, 2 workers"]
    assert [it.row for it in suite.benchmarks_in(tmp_path, True)] == ["C PingPong"]


def test_iterations_of_benchmarks_are_read_and_workers_compared() -> None:
    said = "Iteration 1 - 3.250 ms\nIteration: 2\t - 2.5 ms\nBest Time:\t 2.5 msec\n"
    assert suite.iterations_in(said) == [3.25, 2.5]
    assert suite.iterations_in("Iteration 1\t- 2 ms\t= 2500 µs\t= 2500125 ns\n") == [2.500125]
    with pytest.raises(LfError, match="no result"):
        suite.iterations_in("Success.\n")
    times = {"C MatMul": 100.0, "C MatMul, 1 worker": 110.0, "C MatMul, 2 workers": 55.0, "C Big": 5.0}
    table = suite.speed_ups(Measured(row, "ours", "ms", value) for row, value in times.items())
    assert table["headings"] == ["", "ours: one worker / two", "ours: one worker / none"]
    assert table["rows"] == [["C MatMul", number(2.0, digits=2), number(1.1, digits=2)]]


def test_who_has_failed_is_not_measured_again_and_some_must_not_fail() -> None:
    def good() -> list[Measured]:
        return [Measured("row", "good", "ms", 1.0)]

    def bad() -> list[Measured]:
        raise LfError("compiling\nP.lf:1:1: error: no such port\nstopped")

    runs = [("row", "bad", bad), ("row", "good", good)]
    seen = in_turns(2, runs, must_succeed=["good"])
    assert seen == [Measured("row", "bad", "", error="error: no such port"), *good(), *good()]
    with pytest.raises(LfError, match="no such port"):
        in_turns(2, runs, must_succeed=["bad"])
