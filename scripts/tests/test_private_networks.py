# SPDX-License-Identifier: Apache-2.0
"""Virtual boards: the network that is made for them, what is started in it, and what is left of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from ipaddress import ip_address, ip_interface
from pathlib import Path

import pytest
from conftest import LF, SAY, World
from test_runs import BOARD, planned

from lf_west import private_network, qemu
from lf_west.description import Network
from lf_west.errors import LfError
from lf_west.federation import Bench
from lf_west.main import main
from lf_west.private_network import PrivateNetwork, plan_network

RTI = ip_address("10.0.0.1")


def board(address: str, gateway: str | None = None) -> Network:
    return Network(ip_interface(address), None if gateway is None else ip_address(gateway), None)


def addresses(network: PrivateNetwork) -> list[str]:
    return [str(address) for address in network.addresses]


@pytest.fixture
def grid(grid: World) -> World:
    """A program, an image with an interface of its own, and an image for a board of QEMU; all print what they get."""
    grid.describe(a="host", b=BOARD, c="qemu_cortex_m3@A", d=BOARD)
    grid.attach("10.0.0.1", b="10.0.0.2/24", c="10.0.0.3/24")
    ended = "print('lf: the program ended with status 0', flush=True)"
    grid.program("qemu-system-arm", f"{SAY}\n{ended}\nsignal.pause()\n")
    return grid


def test_a_bridge_has_an_interface_per_board_and_the_rtis_address() -> None:
    network = plan_network({"a": board("10.0.0.2/24"), "b": board("10.0.0.3/24")}, RTI)
    assert network.interfaces == {"a": "lf0", "b": "lf1"}
    assert addresses(network) == ["10.0.0.1/24"]
    commands = network.commands()
    assert "tuntap add dev lf1 mode tap" in commands
    assert "link set dev lf1 master lfbridge up" in commands
    assert "address add 10.0.0.1/24 dev lfbridge" in commands
    assert not network.forwards


def test_this_computer_is_the_gateway_between_the_boards_networks() -> None:
    boards = {"a": board("10.0.0.2/24", "10.0.0.1"), "b": board("10.9.0.2/16", "10.9.0.1")}
    network = plan_network(boards, RTI)
    assert sorted(addresses(network)) == ["10.0.0.1/24", "10.9.0.1/16"]
    assert network.forwards


def test_an_rti_behind_a_gateway_has_an_address_by_itself() -> None:
    network = plan_network({"a": board("10.9.0.2/16", "10.9.0.1")}, RTI)
    assert sorted(addresses(network)) == ["10.0.0.1/32", "10.9.0.1/16"]


def test_a_network_of_ipv6_is_made_likewise() -> None:
    boards = {"a": board("fd00::2/64", "fd00::1"), "b": board("fd00:0:0:1::2/64", "fd00:0:0:1::1")}
    network = plan_network(boards, ip_address("fd00::1"))
    assert sorted(addresses(network)) == ["fd00:0:0:1::1/64", "fd00::1/64"]
    assert "address add fd00::1/64 dev lfbridge nodad" in network.commands()
    assert network.forwards
    alone = plan_network({"rti": board("fd00::1/64"), "a": board("fd00::2/64")}, ip_address("fd00::1"))
    assert addresses(alone) == ["fd00::3/64"]


def test_a_participant_in_a_network_of_ipv6_is_told_the_rtis_address(grid: World) -> None:
    grid.attach("fd00::1", b="fd00::2/64", c="fd00::3/64", d="fd00::4/64")
    federates = {item["name"]: item["words"] for item in planned(grid).description(None)["federates"]}
    assert federates["a"][1:3] == ["--rti", "[fd00::1]:15045"]
    assert "-lf-rti-address=fd00::1" in federates["b"]


def give_spare(world: World, name: str, address: str) -> None:
    """Make a federate transient, and let the compiler say that it has a spare board."""
    described = json.loads(world.description.read_text())
    (item,) = (item for item in described["participants"] if item["name"] == name)
    place = {**item["network"], "ip": address, "mac": "02:00:00:00:00:99"}
    item |= {
        "transient": True,
        "spare": {"kconfig": "spare.conf", "overlay": "spare.overlay", "network": place, "probe": None},
    }
    world.write(described)


def test_a_spare_board_is_built_and_has_an_interface_of_its_own(grid: World) -> None:
    give_spare(grid, "c", "10.0.0.13")
    assert main(["lf-fed-build", grid.file]) == 0
    builds = {call[call.index("--build-dir") + 1].rsplit("/", 1)[1]: call for call in grid.calls("west")}
    assert set(builds) == {"b", "c", "c-spare", "d"}
    (confs,) = (word for word in builds["c-spare"] if word.startswith("-DEXTRA_CONF_FILE="))
    assert confs.split("=")[1].split(";")[0] == "spare.conf"
    # It is another image of the same crate.
    crates = [[word for word in builds[name] if word.startswith("-DLF_FEDERATE_CRATE=")] for name in ("c", "c-spare")]
    assert crates[0] == crates[1]
    federation = planned(grid)
    assert federation.network is not None
    assert federation.network.interfaces == {"b": "lf0", "c": "lf1", "c-spare": "lf2"}
    described = federation.description(None)
    processes = {item["name"]: item for item in described["federates"]}
    assert set(processes) == {"a", "b", "c", "d"}
    spare = processes["c"]["instances"]["spare"]
    assert "ifname=lf2," in spare[6] and spare[6].endswith("mac=02:00:00:00:00:99")
    assert spare[-1].endswith("/c-spare/zephyr/zephyr.elf")
    assert [processes[name]["instances"] for name in "abd"] == ["any", "one", "any"]


def test_the_pins_of_both_boards_of_a_federate_are_recorded(grid: World) -> None:
    give_spare(grid, "c", "10.0.0.13")
    federation = replace(planned(grid), bench=Bench(vcd=Path("pins.vcd")))
    for name in "bd":
        (federation.application.image_folder(name) / "zephyr" / ".config").write_text("")
    described = federation.description(None)
    recorded = {part["name"]: part["file"] for part in described["oscilloscope"]["parts"]}
    assert list(recorded) == ["a", "c", "c-spare"]
    (meter,) = (item for item in described["federates"] if item["name"] == "c")
    traces = [words[words.index("-D") + 1] for words in (meter["words"], meter["instances"]["spare"])]
    assert traces == [recorded["c"], recorded["c-spare"]]


def test_the_rti_takes_commands_for_images_that_come_and_go(grid: World) -> None:
    described = planned(grid).description(None)
    assert described["rti"]["streams"] == "lines" and "--commands" not in described["rti"]["words"]
    assert [item["image_id"] for item in described["federates"]] == [None] * 4
    give_spare(grid, "c", "10.0.0.13")
    described = planned(grid).description(None)
    assert described["rti"]["streams"] == "commands" and described["rti"]["words"][-1] == "--commands"
    assert [item["image_id"] for item in described["federates"]] == [None, None, 2, None]


def test_what_is_left_out_is_started_later(grid: World) -> None:
    planned_here = planned(grid, without=("b",)).description(None)
    assert [item["name"] for item in planned_here["federates"]] == ["a", "c", "d"]
    assert [item["name"] for item in planned_here["left_out"]] == ["b"]
    with pytest.raises(LfError, match="Grid has no federate e"):
        planned(grid, without=("e",))
    with pytest.raises(LfError, match="--without: d is not among those of -f"):
        planned(grid, federates=("a",), without=("d",))


def test_programs_reach_an_rti_on_a_board_from_a_free_address() -> None:
    network = plan_network({"rti": board("10.0.0.1/29"), "a": board("10.0.0.2/29")}, RTI)
    assert addresses(network) == ["10.0.0.3/29"]
    full = plan_network({"rti": board("10.0.0.1/30"), "a": board("10.0.0.2/30")}, RTI)
    assert addresses(full) == []


def test_a_participant_in_a_private_network_knows_the_deployed_rti(grid: World) -> None:
    federation = planned(grid)
    described = federation.description(None)
    assert described["id"] == {"exactly": "Grid"}
    assert described["grace_ns"] == 30_000_000_000
    assert described["rti"]["words"][2:6] == ["--id", "Grid", "--port", "15045"]
    statuses = {item["name"]: item["status_line"] for item in described["federates"]}
    assert statuses == {"a": None, "b": None, "c": qemu.STATUS_LINE, "d": None}
    # Images do not know where in the LF program their code stands.
    crates = {item["name"]: item["crate"] for item in described["federates"]}
    assert crates["a"] is None and all(crates[name].endswith(f"/{name}") for name in "bcd")
    commands = {item["name"]: item["words"] for item in described["federates"]}
    assert commands["a"][1:] == ["--rti", "10.0.0.1:15045", "--id", "Grid"]
    options = ["-lf-federation-id=Grid", "-lf-rti-address=10.0.0.1", "-lf-rti-port=15045"]
    assert commands["b"][1:] == [*options, "-eth-if=lf0"]
    assert commands["d"][1:] == options
    assert commands["c"][:5] == ["qemu-system-arm", "-machine", "lm3s6965evb", "-cpu", "cortex-m3"]
    nic = "tap,ifname=lf1,script=no,downscript=no,model=stellaris,mac=02:00:00:00:00:02"
    assert commands["c"][5:7] == ["-nic", nic]
    assert commands["c"][-1].endswith("/c/zephyr/zephyr.elf")


def test_a_federation_with_virtual_boards_is_run_whole(grid: World) -> None:
    with pytest.raises(LfError, match="in a network of their own, which federates that are started by hand cannot"):
        planned(grid, federates=("b",))
    with pytest.raises(LfError, match="--rti-port: the images of virtual boards know the port 15045"):
        planned(grid, port=20000)


def test_boards_of_qemu_need_addresses(world: World) -> None:
    world.describe(a="host", b="qemu_cortex_m3", c="mps2/an385")
    world.program("grid-a", "")
    with pytest.raises(LfError, match="have no addresses in the network of virtual boards: b, c"):
        planned(world)


def test_the_rti_needs_an_address_and_not_a_name(world: World) -> None:
    world.describe(b=BOARD)
    world.attach("localhost", b="10.0.0.2/24")
    with pytest.raises(LfError, match="but the name localhost"):
        planned(world)


@pytest.mark.parametrize(
    ("name", "is_played"),
    [("qemu_cortex_m3", True), ("qemu_cortex_m3/ti_lm3s6965", True), ("mps2/an385", True), ("mps2/an521", False)],
)
def test_boards_that_qemu_plays(name: str, is_played: bool) -> None:
    assert qemu.is_played(name) == is_played


def not_permitted(_flags: int) -> int:
    return 1


def test_where_namespaces_are_not_allowed_it_is_said_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(private_network, "_unshare", not_permitted)
    with pytest.raises(LfError) as raised:
        plan_network({"a": board("10.0.0.2/24")}, RTI).enter()
    message = str(raised.value)
    assert "virtual boards cannot have a private network here: Operation not permitted." in message
    assert "Run the command as root." in message
    assert "native_sim images that have no `ip`" in message


def test_where_there_are_no_network_devices_it_is_said_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(private_network, "_TUN", tmp_path / "tun")
    with pytest.raises(LfError, match="so virtual boards cannot have network interfaces"):
        plan_network({"a": board("10.0.0.2/24")}, RTI).enter()


def test_without_the_tool_for_networks_it_is_said_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(private_network, "_unshare", lambda _flags: 0)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(LfError, match="`ip`, which makes the network of virtual boards, cannot be run"):
        plan_network({"a": board("10.0.0.2/24")}, RTI).enter()


@pytest.fixture(scope="module")
def _allowed() -> None:
    """Skip the tests that need a private network if the system does not allow one."""
    enter = "import test_private_networks as t; t.plan_network({'a': t.board('10.0.0.2/24')}, t.RTI).enter()"
    path = {"PYTHONPATH": f"{LF.parent}:{LF.parent / 'tests'}"}
    result = subprocess.run(
        [sys.executable, "-c", enter], env={**os.environ, **path}, capture_output=True, text=True, check=False
    )
    if result.returncode != 0:
        pytest.skip(f"no private network: {result.stderr.splitlines()[-1]}")


def own_networks() -> str:
    """The network namespace of this process, and the devices in it."""
    devices = subprocess.run(["ip", "-brief", "link"], capture_output=True, text=True, check=True).stdout
    return f"{Path('/proc/self/ns/net').readlink()} {devices}"


def processes_in(namespace: str) -> list[int]:
    """All processes that are in a network namespace."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str((process / "ns/net").readlink()) == namespace:
                found.append(int(process.name))
        except OSError:
            # It has ended meanwhile.
            continue
    return found


SHOW_NETWORK = """
import subprocess
def words(*arguments):
    return [line.split() for line in subprocess.check_output(["ip", "-brief", *arguments], text=True).splitlines()]
print("namespace", pathlib.Path("/proc/self/ns/net").readlink())
print("devices", *sorted(line[0] for line in words("link")))
print("addresses", *words("address", "show", "lfbridge")[0][2:])
"""


@pytest.mark.usefixtures("_allowed")
@pytest.mark.parametrize(("prefix", "length"), [("10.0.0.", 24), ("fd00::", 64)])
def test_a_run_has_a_network_that_is_gone_with_it(prefix: str, length: int, grid: World) -> None:
    grid.attach(f"{prefix}1", b=f"{prefix}2/{length}", c=f"{prefix}3/{length}")
    grid.program("grid-a", SHOW_NETWORK)
    before = own_networks()
    result = grid.run()
    assert result.returncode == 0, result.stderr
    assert "a    | devices lf0 lf1 lfbridge lo\n" in result.stdout
    assert f"a    | addresses {prefix}1/{length}\n" in result.stdout
    assert f"b    | -lf-federation-id=Grid -lf-rti-address={prefix}1 -lf-rti-port=15045 -eth-if=lf0\n" in result.stdout
    assert "c    | lf: the program ended with status 0\n" in result.stdout
    namespace = result.stdout.split("a    | namespace ")[1].split("\n")[0]
    assert namespace != str(Path("/proc/self/ns/net").readlink())
    assert processes_in(namespace) == []
    assert own_networks() == before


@pytest.mark.usefixtures("_allowed")
def test_a_program_that_fails_on_a_board_fails_the_run(grid: World) -> None:
    fail = "print('lf: the program ended with status 7', flush=True)\nsignal.pause()\n"
    grid.program("qemu-system-arm", fail)
    result = grid.run()
    assert result.returncode == 7, result.stderr
    assert "west | c ended with exit status 7" in result.stderr
