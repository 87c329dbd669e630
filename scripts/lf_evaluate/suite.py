# SPDX-License-Identifier: Apache-2.0
"""LF's own benchmarks, which have most of Savina's, with our runtime and with LF's."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile

from lf_evaluate.measured import Measured, Run, in_turns, no_result_in, rounds, telling_line
from lf_evaluate.peers import RUNTIMES, SINGLE_THREADED, WITHOUT, Lfc, project_of
from lf_evaluate.results import Finding, Table, finding, number
from lf_evaluate.setting import FOLDER, Setting, Word, execute
from lf_west.errors import LfError
from lf_west.workspace import REPOSITORY

OURS = "ours"
# The programs of each target language, in a clone of LF's benchmarks.
SOURCES = {"C": "C/Savina/src", "Rust": "Rust/Savina/src"}
# Programs of this folder have parts that can run at the same time.
PARALLEL = "parallelism"
WORKERS = (1, 2)
# Iterations of each program; the best one counts. Their own default is 12.
ITERATIONS = 5
QUICK_ITERATIONS = 2
# No program takes as long, except one that hangs.
TIME_LIMIT_S = 120.0
# The time between two looks at a program's memory.
SAMPLES_S = 0.02


@dataclass(frozen=True)
class Benchmark:
    """A program of the benchmarks, with a number of workers or, for 0, without threads."""

    target: str
    # The file below the sources of its language.
    path: Path
    workers: int

    @property
    def program(self) -> str:
        """The program, without the number of workers."""
        return f"{self.target} {self.path.stem}"

    @property
    def row(self) -> str:
        """Return the name of the program in tables."""
        of_workers = f", {self.workers} worker{'s' if self.workers > 1 else ''}" if self.workers else ""
        return f"{self.program}{of_workers}"


def suite(setting: Setting) -> Finding:
    """Measure the benchmarks with our runtime and, where LF's compiler is named, with LF's, in turns."""
    assert setting.benchmarks is not None
    lfc = Lfc.of(setting)
    iterations = QUICK_ITERATIONS if setting.quick else ITERATIONS
    seen = []
    for benchmark in benchmarks_in(setting.benchmarks, setting.quick):
        runs: list[Run] = []
        for who in (OURS, *([RUNTIMES[benchmark.target]] if lfc and benchmark.target in lfc.targets() else [])):
            try:
                file = _copy(setting.benchmarks, benchmark, iterations, None if who == OURS else lfc)
                program = _build(setting, file) if who == OURS or not lfc else lfc.build(file)
                runs.append((benchmark.row, who, partial(_run, benchmark, who, program)))
            except LfError as error:
                seen.append(Measured(benchmark.row, who, "", error=telling_line(error)))
        seen += in_turns(setting.rounds, runs)
    found = finding(
        "LF's benchmarks",
        "How long do LF's own benchmarks take?",
        [
            f"Time of an iteration, best of {setting.rounds} runs of {iterations} iterations, in turns; and the most "
            "memory that a run had.",
            "The programs are as LF's repository has them, but for the numbers of iterations and of workers.",
        ],
        seen,
        [OURS],
        ["ms", "MB"],
        limits=[] if lfc is not None else [WITHOUT],
    )
    return Finding(**{**found, "tables": [*found["tables"], speed_ups(seen)]})


def benchmarks_in(clone: Path, is_quick: bool) -> list[Benchmark]:
    """Return the programs of a clone; where there is little time, the small ones, without workers."""
    found = []
    for target, source in SOURCES.items():
        folder = clone / source
        if not folder.is_dir():
            raise LfError(f"--benchmarks {clone}: it has no {source}; name a clone of LF's benchmarks-lingua-franca")
        for file in sorted(folder.rglob("*.lf")):
            path = file.relative_to(folder)
            if not re.search(r"^main reactor", file.read_text(encoding="utf-8"), re.MULTILINE):
                continue
            is_parallel = path.parts[0] == PARALLEL
            if not is_quick or path.parts[0] == "micro":
                numbers = (0, *WORKERS) if is_parallel and not is_quick else (0,)
                found += [Benchmark(target, path, workers) for workers in numbers]
    return found


def changed(text: str, benchmark: Benchmark, iterations: int, lfc: Lfc | None) -> str:
    """Return a program with this number of iterations and the benchmark's number of workers, for LF's compiler if it is
    given, and else for ours."""
    # The last one is the main reactor's; a comment that generates other numbers has no digits there.
    found = list(re.finditer(r"(num_?[iI]terations\s*:\s*\w+\s*=\s*)\d+", text))
    if not found:
        raise LfError("error: no parameter of the main reactor is the number of iterations")
    last = found[-1]
    text = f"{text[: last.start()]}{last[1]}{iterations}{text[last.end() :]}"
    text = re.sub(r"^  (?:single-threaded|build-type)\s*:\s*\w+,?", "", text, flags=re.MULTILINE)
    properties = [lfc.properties(benchmark.target) if lfc else "build-type: Release"]
    properties.append(f"workers: {benchmark.workers}" if benchmark.workers else SINGLE_THREADED)
    if benchmark.target == "Rust" and lfc is None:
        # `gen` is a name in these programs, and became a keyword of Rust 2024; reactor-rs logs warnings only.
        properties += ['edition: "2021"', "logging: warn"]
    return re.sub(r"^target (\w+) \{", rf"target \1 {{ {', '.join(properties)},", text, count=1, flags=re.MULTILINE)


def _copy(clone: Path, benchmark: Benchmark, iterations: int, lfc: Lfc | None) -> Path:
    """Copy the sources of the benchmark's language, and return the changed program in the copy."""
    project = FOLDER / "suite" / ("lfc" if lfc else "ours") / benchmark.row.replace(", ", "-").replace(" ", "-")
    shutil.rmtree(project / "src", ignore_errors=True)
    shutil.copytree(clone / SOURCES[benchmark.target], project / "src")
    file = project / "src" / benchmark.path
    file.write_text(changed(file.read_text(encoding="utf-8"), benchmark, iterations, lfc), encoding="utf-8")
    return file


def _build(setting: Setting, file: Path) -> Path:
    """Compile a program in `PROJECT/src`, and return the executable file in `PROJECT/bin`."""
    project = project_of(file)
    folders: list[Word] = ["--out", project / "build", "--target-dir", FOLDER / "cargo", "--home", REPOSITORY]
    told = json.loads(execute([setting.lfz, "build", file, "--release", "--quiet", "--json", *folders]))
    (project / "bin").mkdir(exist_ok=True)
    # Another program of this name is compiled to the same place.
    return Path(shutil.copy2(told["participants"][0]["program"], project / "bin" / file.stem))


def _run(benchmark: Benchmark, who: str, program: Path) -> list[Measured]:
    """Run a program, and return its best iteration and its memory."""
    command = [str(program)]
    if benchmark.target == "Rust" and who != OURS and benchmark.workers:
        command += ["--workers", str(benchmark.workers)]
    deadline = time.monotonic() + TIME_LIMIT_S
    memory = 0
    with TemporaryFile() as output:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)
        try:
            while process.poll() is None:
                # The kernel's count for children begins with the memory of the process that started them.
                memory = max(memory, _most_memory_of(process.pid))
                if time.monotonic() > deadline:
                    process.kill()
                time.sleep(SAMPLES_S)
        finally:
            # An interruption ends the program, too.
            process.kill()
        output.seek(0)
        said = output.read().decode("utf-8", "replace")
    if process.returncode != 0:
        after = f"was ended after {TIME_LIMIT_S:.0f} s" if process.returncode == -9 else f"status {process.returncode}"
        raise LfError(f"{after}: {said[-500:]}")
    one = Measured(benchmark.row, who, "ms", min(iterations_in(said)))
    return [one, replace(one, unit="MB", value=memory / 1e6)]


def _most_memory_of(process: int) -> int:
    """Return the most bytes of memory that a running process had so far; 0 where they cannot be told any more."""
    try:
        found = re.search(
            r"^VmHWM:\s*(\d+) kB", Path(f"/proc/{process}/status").read_text(encoding="utf-8"), re.MULTILINE
        )
    except OSError:
        found = None
    return int(found[1]) * 1024 if found else 0


def iterations_in(output: str) -> list[float]:
    """Parse `Iteration 1 - 2.5 ms` of C, and `Iteration 1 - 2 ms = 2500 µs = 2500000 ns` of Rust; in ms."""
    times = [
        float(nanoseconds) / 1e6 if nanoseconds else float(milliseconds)
        for milliseconds, nanoseconds in re.findall(
            r"^Iteration:?\s+\d+\s*-\s*([\d.]+) ms(?:\s*=\s*\d+ µs\s*=\s*(\d+) ns)?", output, re.MULTILINE
        )
    ]
    if not times:
        raise no_result_in(output)
    return times


def speed_ups(seen: Iterable[Measured]) -> Table:
    """Return how much quicker the parallel programs are with two workers, and one worker beside none."""
    best = {(row, who): min(values) for (row, who, unit), values in rounds(seen).items() if unit == "ms"}
    owners = dict.fromkeys(who for _, who in best)
    programs = [row.removesuffix(", 1 worker") for row, _ in best if row.endswith(", 1 worker")]
    rows = []
    for program in dict.fromkeys(programs):
        cells = []
        for who in owners:
            none, one, two = (best.get((f"{program}{it}", who)) for it in ("", ", 1 worker", ", 2 workers"))
            cells += [number(one / two, digits=2) if one and two else ""]
            cells += [number(one / none, digits=2) if one and none else ""]
        rows.append([program, *cells])
    headings = [f"{who}: {what}" for who in owners for what in ("one worker / two", "one worker / none")]
    return Table(title="Workers", headings=["", *headings], rows=rows)
