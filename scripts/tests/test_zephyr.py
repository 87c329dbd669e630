# SPDX-License-Identifier: Apache-2.0
"""The applications of this repository and the programs beside this file, built as images and run on native_sim.

Federations of images only are also in the applications' folders, for twister.

Everything is built in one folder, which is kept, so that each image is built once, and only what has changed the next
time.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from conftest import BUILD, listening_port

from lf_west import compiler, description
from lf_west.workspace import REPOSITORY, find_workspace

pytestmark = pytest.mark.zephyr

# The time limit in seconds that ends a run that hangs.
LIMIT_S = 300
PROGRAMS = Path(__file__).parent / "programs"
# Names of functions that allocate, from C's library, Zephyr's kernel, or Rust's `alloc` crate.
ALLOCATOR = re.compile(
    r"(k_|_)?(malloc|calloc|realloc|reallocarray|memalign|aligned_alloc)(_r)?|_?free(_r)?|.*__(rust|rg|rdl)_\w*alloc\w*"
)
# Parts of mangled names: those of encrypted connections.
SECURE = re.compile(r"9lf_secure|10lf_runtime6secure")
# SHA-256, the event loop's connections past the RTI, traces, and encryption.
UNUSED = re.compile(
    r"4sha2|10lf_runtime8federate(?:5peers|7inbound|8outbound|12accept_queue|9from_peer)|10lf_runtime5trace"
    rf"|9lf_zephyr5trace|lf_trace_print|{SECURE.pattern}"
)
# Images of the boards that QEMU plays. Those that are the same in several deployments are built once here.
BOARDS = BUILD / "boards"
COMPUTER_AND_BOARD = ("--deployment", str(PROGRAMS / "computer_and_board.yaml"))
GRID_RESULT = {"A": "closed", "B": "open", "C": "open", "D": "closed"}


def lf(name: str, file: str | Path, *arguments: str, build: Path = BUILD, **environment: str) -> str:
    """Run a command on an application, or on the program of a path, and give what it printed."""
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), name, str(REPOSITORY / "applications" / file)]
    result = subprocess.run(
        [*command, "--build-dir", str(build), *arguments],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout
    return result.stdout


def run(file: str | Path, *arguments: str) -> str:
    return lf("lf-fed-run", file, "--timeout", str(LIMIT_S), *arguments)


@contextmanager
def started(command: list[str], **environment: str) -> Iterator[subprocess.Popen[str]]:
    """A program, its outputs in one. Where it hangs it is killed, so that its output ends."""
    variables = {**os.environ, **environment}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=variables
    ) as process:
        watchdog = threading.Timer(LIMIT_S, process.kill)
        watchdog.start()
        try:
            yield process
        finally:
            watchdog.cancel()
            process.kill()


@contextmanager
def rti(*options: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """An RTI and the port on which it listens."""
    with started([str(compiler.find(None, os.environ).path), "rti", "-p", "0", *options]) as process:
        assert process.stdout is not None
        yield process, next(port for port in map(listening_port, map(str.strip, process.stdout)) if port is not None)


@contextmanager
def board(image: Path, federation_id: str, port: int, *options: str) -> Iterator[subprocess.Popen[str]]:
    """An image that joins the federation at this port."""
    with started([str(image), f"-lf-federation-id={federation_id}", f"-lf-rti-port={port}", *options]) as process:
        yield process


@contextmanager
def overslept() -> Iterator[list[int]]:
    """By how many nanoseconds waiting for a millisecond takes too long, while something else runs."""
    times_ns: list[int] = []
    over = threading.Event()

    def measure() -> None:
        begin = time.perf_counter_ns()
        while not over.wait(0.001):
            end = time.perf_counter_ns()
            times_ns.append(end - begin - 1_000_000)
            begin = end

    thread = threading.Thread(target=measure)
    thread.start()
    try:
        yield times_ns
    finally:
        over.set()
        thread.join()


def run_alone(file: str | Path) -> subprocess.CompletedProcess[str]:
    """Build a program without federates for native_sim, and run its image."""
    output = lf("lf-build", file, "-w", "-b native_sim/native/64")
    image = Path(output.split()[-1])
    assert image.is_relative_to(BUILD)
    return subprocess.run([image], capture_output=True, text=True, timeout=LIMIT_S, check=False)


@pytest.fixture(scope="session")
def _arm() -> None:
    """Boards with an Arm processor need a compiler, which the build finds by itself."""
    chosen = {"ZEPHYR_TOOLCHAIN_VARIANT", "ZEPHYR_SDK_INSTALL_DIR"} & os.environ.keys()
    has_sdk = (Path.home() / ".cmake/packages/Zephyr-sdk").is_dir()
    if not chosen and not has_sdk and shutil.which("arm-none-eabi-gcc") is None:
        pytest.skip("no compiler for Arm: there is neither a Zephyr SDK nor arm-none-eabi-gcc in PATH")


def symbols(folder: Path) -> dict[str, int]:
    """The names that are linked into an image, with their addresses."""
    # The nm that belongs to the compiler which built the image.
    tool = re.search(r"^CMAKE_NM:\w+=(.+)$", (folder / "CMakeCache.txt").read_text(), re.MULTILINE)
    assert tool is not None
    command = [tool[1], str(folder / "zephyr/zephyr.elf")]
    lines = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    fields = [line.split() for line in lines]
    return {field[2]: int(field[0], 16) for field in fields if len(field) == 3}


def circuits(output: str) -> dict[str, str]:
    """Return the decisions that the units of the smart grid print."""
    lines = re.findall(r"^(\w) +\| ([A-D]): (open|closed), reaction time [0-9.]+ ms$", output, re.MULTILINE)
    assert all(federate.upper() == unit for federate, unit, _ in lines), output
    return {unit: state for _, unit, state in lines}


def test_a_thread_schedules_a_physical_action() -> None:
    result = run_alone(PROGRAMS / "Readings.lf")
    assert result.returncode == 0, result.stdout + result.stderr
    lines = [line for line in result.stdout.splitlines() if "reading" in line]
    assert lines == ["reading 1 is 11", "reading 2 is 22", "reading 3 is 33", "3 of 3 readings came"]
    # The target property `user-threads` arrives in the image.
    config = (BUILD / "zephyr/Readings/Readings/zephyr/.config").read_text()
    assert "CONFIG_LF_USER_THREADS=1\n" in config


def test_images_have_the_c_the_options_and_the_settings_of_their_own_federates() -> None:
    output = run(REPOSITORY / "tests/federations/programs/c_beside/CBeside.lf", "-w", "-b native_sim/native/64")
    said = re.findall(r"^sum +\| (\d+ and \d+)$", output, re.MULTILINE)
    # The option begins at 100 in the image of `left` only.
    assert said == ["103 and 1", "106 and 2", "109 and 4"], output


def test_a_thread_too_many_ends_the_program_with_what_to_do() -> None:
    result = run_alone(PROGRAMS / "TooManyThreads.lf")
    output = result.stdout + result.stderr
    assert result.returncode == 1, output
    assert "the body went on" in output
    # The sentence comes whole, with what to do at its end.
    assert "all of the image's threads (1) were running" in output
    assert "or set CONFIG_LF_USER_THREADS\n" in output
    assert "nothing happens after the error" not in output


@pytest.mark.usefixtures("_arm")
def test_the_sender_of_the_message_test_fits_a_small_board_without_an_allocator(
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = ("-f", "sender", "--deployment", "deployment/topology4.yaml")
    output = lf("lf-fed-build", "message_test/src/MessageTest.lf", *arguments, build=BOARDS)
    sizes = re.search(r"^sender +qemu_cortex_m3 +([0-9.]+ KiB) +([0-9.]+ KiB) ", output, re.MULTILINE)
    assert sizes is not None, output
    with capsys.disabled():
        print(f"\nthe message test's sender on qemu_cortex_m3: {sizes[1]} of flash, {sizes[2]} of RAM")
    linked = symbols(BOARDS / "zephyr/MessageTest/sender")
    assert "lf_main" in linked
    assert [name for name in linked if ALLOCATOR.fullmatch(name)] == []
    # The kernel's own functions refer to its functions for heaps, but there is no heap.
    assert linked["_k_heap_list_start"] == linked["_k_heap_list_end"]
    # Nor is there anything of authentication, encryption and connections with other federates, which the program does
    # not use, and of traces, which the image does not use.
    assert [name for name in linked if UNUSED.search(name)] == []


@pytest.mark.usefixtures("_arm")
@pytest.mark.parametrize(("rti", "topology"), [("a", "topology3"), ("rti", "topology4")])
def test_the_rti_of_the_smart_grid_fits_a_small_board_without_an_allocator(
    rti: str, topology: str, capsys: pytest.CaptureFixture[str]
) -> None:
    deployment = ("--deployment", f"deployment/{topology}.yaml")
    file = "smart_grid/src/SmartGrid.lf"
    output = lf("lf-fed-build", file, "-f", rti, *deployment, build=BOARDS)
    sizes = re.search(rf"^{rti} +qemu_cortex_m3 +([0-9.]+ KiB) +([0-9.]+ KiB) ", output, re.MULTILINE)
    assert sizes is not None, output
    with capsys.disabled():
        print(f"\nthe RTI of the smart grid in {rti} on qemu_cortex_m3: {sizes[1]} of flash, {sizes[2]} of RAM")
    linked = symbols(BOARDS / "zephyr/SmartGrid" / rti)
    assert ("lf_rti_main" in linked, "lf_main" in linked) == (True, rti == "a")
    assert [name for name in linked if ALLOCATOR.fullmatch(name)] == []
    assert linked["_k_heap_list_start"] == linked["_k_heap_list_end"]


def test_recordings_of_images_are_put_together_from_their_consoles(tmp_path: Path) -> None:
    settings = tmp_path / "trace.conf"
    settings.write_text("CONFIG_LF_TRACE=y\nCONFIG_LF_TRACE_RECORDS=512\nCONFIG_LF_TRACE_VALUES=y\n")
    build = BUILD / "traced"
    deployment = ("--deployment", "deployment/native_sim.yaml")
    arguments = (*deployment, "-c", str(settings), "--timeout", "300")
    output = lf("lf-fed-run", "message_test/src/MessageTest.lf", *arguments, build=build)
    (tmp_path / "boards.log").write_text(output)
    # The receiver has messages with their values: records whose kind is that of a value's last part.
    assert re.search(r"lf-trace 1 [0-9a-f]{48}11[0-9a-f]{14}", output), output
    (names,) = build.rglob("trace.json")
    command = [str(compiler.find(None, os.environ).path), "trace", str(tmp_path), "--names", str(names)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    for words in ["sender: ", "receiver: ", "receiver.reaction_1 (MessageTest.lf:", "the oldest "]:
        assert words in result.stdout, result.stdout
    # Each of the newest messages is seen at both ends.
    arrows = re.search(r"2 participants and (\d+) arrows", result.stderr)
    assert arrows is not None, result.stderr
    assert int(arrows[1]) > 10
    assert b"sender.y -> receiver.x" in (tmp_path / "trace.perfetto-trace").read_bytes()


def test_the_smart_grid_heals_itself_with_units_on_linux_and_on_native_sim() -> None:
    output = run("smart_grid/src/SmartGrid.lf", "--deployment", "deployment/topology2.yaml")
    assert re.search(r"^a +host ", output, re.MULTILINE), output
    assert re.search(r"^b +native_sim/native/64 ", output, re.MULTILINE), output
    assert circuits(output) == GRID_RESULT, output


def test_the_smart_grid_heals_itself_with_the_rti_in_the_image_of_a_unit() -> None:
    output = run("smart_grid/src/SmartGrid.lf", "--deployment", "deployment/joint_rti.yaml")
    assert circuits(output) == GRID_RESULT, output
    assert not re.search(r"^RTI +\|", output, re.MULTILINE), output
    assert "CONFIG_LF_RTI_FEDERATES=4\n" in (BUILD / "zephyr/SmartGrid/a/zephyr/.config").read_text()


def test_a_joint_rti_without_a_port_ends_the_federate_too() -> None:
    lf("lf-fed-build", "smart_grid/src/SmartGrid.lf", "--deployment", "deployment/joint_rti.yaml")
    image = BUILD / "zephyr/SmartGrid/a/zephyr/zephyr.exe"
    with rti("-n", "1") as (_, port), board(image, "joint", port) as joint:
        output = joint.communicate()[0]
    assert joint.returncode == 1, output
    assert f"the RTI cannot listen on TCP port {port}: the port is in use by another program" in output


def test_the_smart_grid_heals_itself_with_the_rti_as_an_image_of_its_own() -> None:
    output = run("smart_grid/src/SmartGrid.lf", "--deployment", "deployment/rti_alone.yaml")
    assert re.search(r"^rti +native_sim/native/64 ", output, re.MULTILINE), output
    assert circuits(output) == GRID_RESULT, output


def test_an_rti_that_is_an_image_authenticates_and_tells_federates_where_others_are() -> None:
    output = run(PROGRAMS / "Squares.lf", "--deployment", str(PROGRAMS / "rti_alone.yaml"))
    assert re.search(r"^computer +\| 50 squares add up to 42925$", output, re.MULTILINE), output


def test_the_decentralized_smart_grid_heals_itself_or_says_which_message_was_late() -> None:
    """No RTI grants tags, so on a busy computer messages may be late; then units are safe rather than clever."""
    output = run("smart_grid/src/SmartGridAfter.lf", "--deployment", "deployment/topology2.yaml")
    assert re.search(r"^a +host ", output, re.MULTILINE), output
    assert re.search(r"^b +native_sim/native/64 ", output, re.MULTILINE), output
    units = circuits(output)
    if "late message to federate" in output:
        assert (units["B"], units["C"]) == ("open", "open"), output
    else:
        assert units == GRID_RESULT, output


def test_images_with_the_sockets_of_this_computer_find_the_rti_and_each_other_over_ipv6() -> None:
    """Decentralized, so that they are told each other's address."""
    output = run("message_test/src/MessageTestDecentralized.lf", "--deployment", "deployment/native_sim_ipv6.yaml")
    assert re.search(r"^receiver +\| received 3000 of 3000 messages in order, ", output, re.MULTILINE), output


def test_images_in_a_cycle_without_delay_answer_each_other_within_a_tag() -> None:
    output = run(PROGRAMS / "QuestionAndAnswer.lf")
    answers = re.findall(r"^asks +\| at ([0-9]+) ms the answer is (\S+)$", output, re.MULTILINE)
    expected = ["Some(10)", "Some(0)", "Some(20)", "Some(0)", "None", "Some(0)", "Some(40)"]
    assert answers == [(str(10 * index), answer) for index, answer in enumerate(expected)], output


def test_a_computer_and_a_board_authenticate_and_send_to_each_other_past_the_rti() -> None:
    output = run(PROGRAMS / "Squares.lf", *COMPUTER_AND_BOARD)
    assert re.search(r"^computer +host ", output, re.MULTILINE), output
    assert re.search(r"^board +native_sim/native/64 ", output, re.MULTILINE), output
    assert re.search(r"^computer +\| 50 squares add up to 42925$", output, re.MULTILINE), output


@pytest.mark.parametrize(
    ("authenticates", "federation_id", "options", "words"),
    [
        (True, "another", ["-a"], "start the RTI and all federates with the same federation id"),
        (True, "right", [], "does not use authentication (code 7). Start the RTI with authentication (`-a`)"),
        (False, "another", [], "(code 1). Start the RTI and all federates with the same federation id"),
        (
            False,
            "right",
            ["-a"],
            "(code 4). Start the RTI with the number of federates that the program has (`-n`), of the same release",
        ),
    ],
)
def test_an_image_that_does_not_belong_to_the_rti_says_so_and_what_to_do(
    authenticates: bool, federation_id: str, options: list[str], words: str
) -> None:
    if authenticates:
        lf("lf-fed-build", PROGRAMS / "Squares.lf", *COMPUTER_AND_BOARD)
        image = BUILD / "zephyr/Squares/board/zephyr/zephyr.exe"
    else:
        lf("lf-fed-build", PROGRAMS / "QuestionAndAnswer.lf")
        image = BUILD / "zephyr/QuestionAndAnswer/asks/zephyr/zephyr.exe"
    with rti("-n", "2", "-i", "right", *options) as (process, port), board(image, federation_id, port) as refused:
        output = refused.communicate()[0]
        assert refused.returncode == 1, output
        assert words in output
        assert process.stdout is not None
        assert any("refuse" in line for line in process.stdout), output


def test_the_drift_of_a_board_is_found_out_while_it_runs() -> None:
    """The board's clock gains 1 ms in a second, and would be 6 ms off in the end."""
    lf("lf-fed-build", PROGRAMS / "Drifting.lf")
    image = BUILD / "zephyr/Drifting/board/zephyr/zephyr.exe"
    with (
        overslept() as times_ns,
        rti("-n", "1", "-i", "drifting", "-c", "on", "period", "5000000") as (process, port),
        board(image, "drifting", port, "-rt-drift=0.001") as drifting,
    ):
        output = drifting.communicate()[0]
        assert drifting.returncode == 0, output
        assert process.wait() == 0
    assert_drift_was_found(output, times_ns)


def test_late_messages_at_a_drifting_board_are_handled_or_reported(tmp_path: Path) -> None:
    lf("lf-fed-build", PROGRAMS / "HeldUp.lf", *COMPUTER_AND_BOARD)
    program = description.load(BUILD / "zephyr/HeldUp/federation.json").select(["computer"])[0].program
    image = BUILD / "zephyr/HeldUp/board/zephyr/zephyr.exe"
    os.mkfifo(tmp_path / "gate")
    gate = os.open(tmp_path / "gate", os.O_RDWR)
    with rti("-n", "2", "-i", "held up", "-c", "on", "period", "5000000") as (process, port):
        command = [str(program), "--rti", f"127.0.0.1:{port}", "--id", "held up"]
        with (
            overslept() as times_ns,
            started(command, LF_TEST_GATE=str(tmp_path / "gate")) as computer,
            board(image, "held up", port, "-rt-drift=0.001") as drifting,
        ):
            lines = []
            assert drifting.stdout is not None
            for line in drifting.stdout:
                lines.append(line)
                if "past the first tag" in line:
                    os.write(gate, b".")
            output = "".join(lines)
            assert drifting.wait() == 0, output
            said = computer.communicate()[0]
            assert computer.returncode == 0, said
            assert process.wait() == 0
    os.close(gate)
    assert "handled Some(42)" in output
    # More may have come by the stop tag.
    counted = re.search(r"counted up to ([0-9]+)", output)
    assert counted is not None, output
    assert int(counted[1]) >= 200
    late = re.search(
        r"late message to federate 1 over computer\.count -> board\.count for \(T0 \+ 0 ns = 0 ms, 0\): "
        r"it happens at \(T0 \+ [0-9]+ ns = [0-9]+ ms, [1-9]\), ([0-9.]+)(m?)s after its time\n",
        output,
    )
    assert late is not None, output
    # The board's first tag is 10 ms later. It began after @maxwait, and ended after @absent_after.
    assert float(late[1]) * (1 if late[2] else 1000) >= 10 + 5 + 20
    assert "give the reactions tardy handlers\n" in output
    # The computer has the clock of the RTI, so there is nothing to find out.
    assert "rounds over UDP" not in said
    assert_drift_was_found(output, times_ns)


def assert_drift_was_found(output: str, times_ns: list[int]) -> None:
    """The board says that its clock gains something like 1 ms in a second, if this computer had the time for it."""
    rounds = re.search(r"([0-9]+) rounds over UDP", output)
    assert rounds is not None, output
    assert int(rounds[1]) > 0, output
    # A simulated clock stands still while its computer has no time for it. When that happens again and again, there is
    # no line to be found in what it says; how drifts are found otherwise, the tests of the coordination prove.
    usual_ns = statistics.quantiles(times_ns, n=10)[-1]
    if usual_ns > 500_000:
        pytest.skip(f"this computer is too busy for a simulated clock: waiting takes {usual_ns / 1e6:.1f} ms too long")
    gained = re.search(r"rounds over UDP.*the own clock gains ([0-9]+) ns in a second", output)
    assert gained is not None, output
    # The computer holds the simulated board up now and then, so only the magnitude is certain.
    assert 500_000 < int(gained[1]) < 2_000_000, output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "choose it with -DLF_FEDERATE=NAME, among sender, receiver"),
        (["-DLF_FEDERATE=nobody"], "lfz could not build"),
        (["-DLF_FEDERATE=sender", "-DLF_DEPLOYMENT=deployment/topology1.yaml"], "no federate on this platform"),
        (["-DLF_COMPILER=/no/lfz"], "There is no lfz"),
    ],
)
def test_west_build_says_what_to_choose(arguments: list[str], words: str, tmp_path: Path) -> None:
    """In an application's folder, without the commands for LF."""
    environment = {**os.environ, "LFZ": str(compiler.find(None, os.environ).path)}
    command = ["cmake", "-S", str(REPOSITORY / "applications/message_test"), "-B", str(tmp_path)]
    command += ["-GNinja", "-DBOARD=native_sim/native/64", *arguments]
    result = subprocess.run(command, env=environment, stderr=subprocess.PIPE, text=True, check=False)
    assert result.returncode != 0
    assert words in " ".join(result.stderr.split()), result.stderr


def test_a_wrong_setting_ends_the_build_with_its_log(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.conf"
    wrong.write_text("CONFIG_NO_SUCH_SYMBOL=y\n")
    command = [sys.executable, str(REPOSITORY / "scripts/lf"), "lf-fed-build"]
    file = str(REPOSITORY / "applications/message_test/src/MessageTest.lf")
    board = ["-w", "-b native_sim/native/64", "-f", "sender", "-c", str(wrong), "-d", str(tmp_path / "build")]
    result = subprocess.run([*command, file, *board], capture_output=True, text=True, check=False)
    assert result.returncode != 0
    assert "NO_SUCH_SYMBOL" in result.stderr
    assert "Read the whole log" in result.stderr


DESCRIBED = """
reactor: Limit
file: Limit.lf
cases:
  - name: it rises
    inputs: [{ at: 0 ms, x: 1 }, { at: 10 ms, x: 3 }]
    outputs: [{ at: 0 ms, y: false }, { at: 10 ms, y: true }]
  - name: it falls
    inputs: [{ at: 10 ms, x: 3 }]
    outputs: [{ at: 10 ms, y: false }]
"""
LIMIT = """target Rust
reactor Limit {
    input x: u8
    output y: bool
    reaction(x) -> y {= ctx.set(y, ctx.get(x) > Some(2)); =}
}
"""


@pytest.mark.parametrize(("board", "case"), [("native_sim/native/64", "it"), ("qemu_cortex_m3", "it rises")])
def test_tests_of_a_reactor_run_as_images(board: str, case: str, request: pytest.FixtureRequest) -> None:
    if "qemu" in board:
        request.getfixturevalue("_arm")
    folder = BUILD / "lfz-test" / board.split("/")[0]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "Limit.lf").write_text(LIMIT)
    (folder / "limit.test.yaml").write_text(DESCRIBED)
    lfz = str(compiler.find(None, os.environ).path)
    command = [lfz, "test", str(folder), "--board", board, "--filter", case]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "limit: it rises ... ok" in result.stdout, result.stderr
    if case == "it":
        assert result.stdout.endswith("1 passed, 1 failed\n")
        # The earlier output of the build is no reason.
        assert result.stderr.lstrip().startswith("*** Booting Zephyr")
        assert "y is true at (10000000, 0), instead of false at (10000000, 0)" in result.stderr


def test_zephyrs_own_tools_build_and_run_a_new_program(tmp_path: Path) -> None:
    """Twister, on the sample.yaml and the CMakeLists.txt that `lfz new --board` makes."""
    board = "native_sim/native/64"
    lfz = str(compiler.find(None, os.environ).path)
    workspace = find_workspace(os.environ)
    # Twister has one tool chain per run. All images compile their common part once.
    environment = workspace.environment(os.environ) | {"LFZ": lfz, "ZEPHYR_TOOLCHAIN_VARIANT": "host"}
    environment |= {"CARGO_TARGET_DIR": str(REPOSITORY / "target/lf-zephyr")}
    # An image of a federation runs in one only, and is built in other tests.
    for name, new, how in (("my_program", [], []), ("my_federation", ["--federated"], ["--cmake-only"])):
        subprocess.run([lfz, "new", name, "--board", board, *new], cwd=tmp_path, check=True)
        command = ["west", "twister", "-T", str(tmp_path / name), "-p", board, "-O", str(tmp_path / "out"), "-i", "-c"]
        result = subprocess.run(
            [*command, *how], cwd=workspace.topdir, env=environment, capture_output=True, text=True, check=False
        )
        assert result.returncode == 0, result.stdout + result.stderr
        [suite] = json.loads((tmp_path / "out/twister.json").read_text())["testsuites"]
        assert suite["status"] == ("not run" if how else "passed"), suite
