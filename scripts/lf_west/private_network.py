# SPDX-License-Identifier: Apache-2.0
"""The network of virtual boards: a bridge with one TAP interface per board, in a network namespace of its own.

The namespace belongs to this process and those that it starts. The kernel removes it, with all that is in it, when the
last of them has ended, however that comes about. Nothing in it can reach another network.
"""

from __future__ import annotations

import ctypes
import errno
import itertools
import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from ipaddress import (
    IPv4Address,
    IPv4Interface,
    IPv6Address,
    IPv6Interface,
    ip_interface,
    ip_network,
)
from pathlib import Path

from lf_west.description import Network
from lf_west.errors import LfError

_BRIDGE = "lfbridge"
# The device that makes a TAP interface for a program, which is then the board's Ethernet.
_TUN = Path("/dev/net/tun")
# Absent on a computer without IPv6.
_IPV6_FORWARDING = Path("/proc/sys/net/ipv6/conf/all/forwarding")
# As in sched.h.
_CLONE_NEWUSER, _CLONE_NEWNET = 0x10000000, 0x40000000


@dataclass(frozen=True)
class PrivateNetwork:
    """The network to create."""

    # The name of each board's TAP interface.
    interfaces: Mapping[str, str]
    # This computer's addresses in it.
    addresses: tuple[IPv4Interface | IPv6Interface, ...]
    # Whether boards reach each other through this computer, which is the gateway between their networks.
    forwards: bool

    def enter(self) -> None:
        """Move this process into a new namespace and make the network there. There is no way back out."""
        if not _TUN.exists():
            raise LfError(
                f"there is no {_TUN}, so virtual boards cannot have network interfaces.",
                "Load the kernel's module for it: modprobe tun",
                "Give it to the container: --device /dev/net/tun",
                _WITHOUT_NETWORK,
            )
        _leave_all_networks()
        _make(self.commands())
        if self.forwards:
            _forward()

    def commands(self) -> list[str]:
        """The commands for `ip -batch` that make it."""
        # Without addresses of IPv6 the computer says nothing by itself.
        lines = ["link set dev lo up", f"link add {_BRIDGE} type bridge", f"link set dev {_BRIDGE} addrgenmode none"]
        for interface in self.interfaces.values():
            lines.append(f"tuntap add dev {interface} mode tap")
            lines.append(f"link set dev {interface} addrgenmode none")
            lines.append(f"link set dev {interface} master {_BRIDGE} up")
        # An address of IPv6 cannot be used until the system has verified that it is unique.
        at_once = {4: "", 6: " nodad"}
        lines += [f"address add {address} dev {_BRIDGE}{at_once[address.version]}" for address in self.addresses]
        return [*lines, f"link set dev {_BRIDGE} up"]


def plan_network(boards: Mapping[str, Network], rti: IPv4Address | IPv6Address) -> PrivateNetwork:
    """Work out the network of these boards; the RTI has this address, on this computer if it is no board's."""
    networks = list(dict.fromkeys(board.ip.network for board in boards.values()))
    taken = {board.ip.ip for board in boards.values()}
    # This computer is all gateways.
    own = {board.gateway: board.ip.network.prefixlen for board in boards.values() if board.gateway is not None}
    around = next((network for network in networks if rti in network), ip_network(rti))
    if rti not in taken:
        own[rti] = around.prefixlen
    elif not own:
        # Programs of this computer reach an RTI on a board from any free address.
        own |= dict.fromkeys(itertools.islice((h for h in around.hosts() if h not in taken), 1), around.prefixlen)
    return PrivateNetwork(
        interfaces={name: f"lf{index}" for index, name in enumerate(boards)},
        addresses=tuple(ip_interface((ip, prefix)) for ip, prefix in own.items() if ip not in taken),
        forwards=len(networks) > 1,
    )


def _leave_all_networks() -> None:
    """Unshare the network. Root may do so directly, other users as the root of a new user namespace."""
    if _unshare(_CLONE_NEWNET) == 0:
        return
    user, group = os.getuid(), os.getgid()
    error = _unshare(_CLONE_NEWUSER | _CLONE_NEWNET)
    if error == 0:
        try:
            _write("/proc/self/setgroups", "deny")
            _write("/proc/self/uid_map", f"0 {user} 1")
            _write("/proc/self/gid_map", f"0 {group} 1")
        except OSError as failure:
            error = failure.errno or errno.EPERM
    if error != 0:
        raise _not_allowed(os.strerror(error))


def _unshare(flags: int) -> int:
    """0, or the error's number."""
    library = ctypes.CDLL(None, use_errno=True)
    return 0 if library.unshare(flags) == 0 else ctypes.get_errno()


def _make(commands: Sequence[str]) -> None:
    text = "".join(f"{line}\n" for line in commands)
    try:
        result = subprocess.run(["ip", "-batch", "-"], input=text, capture_output=True, text=True, check=False)
    except OSError as error:
        raise LfError(
            f"`ip`, which makes the network of virtual boards, cannot be run: {error.strerror}.",
            "Install iproute2.",
            _WITHOUT_NETWORK,
        ) from error
    if result.returncode != 0:
        raise _not_allowed(" ".join(result.stderr.split()))


def _forward() -> None:
    try:
        _write("/proc/sys/net/ipv4/ip_forward", "1")
        if _IPV6_FORWARDING.exists():
            _write(str(_IPV6_FORWARDING), "1")
    except OSError as error:
        raise LfError(
            f"this computer cannot be the gateway between the boards' networks: {error.strerror}.",
            "Give all boards addresses of one network in the deployment file.",
        ) from error


def _write(path: str, text: str) -> None:
    Path(path).write_text(text, encoding="ascii")


def _not_allowed(reason: str) -> LfError:
    return LfError(
        f"virtual boards cannot have a private network here: {reason}.",
        "Run the command as root.",
        "Let users have namespaces: sysctl kernel.unprivileged_userns_clone=1 user.max_user_namespaces=1000, "
        "and on Ubuntu also kernel.apparmor_restrict_unprivileged_userns=0",
        "In a container: start it with --cap-add NET_ADMIN --cap-add SYS_ADMIN --device /dev/net/tun",
        _WITHOUT_NETWORK,
    )


_WITHOUT_NETWORK = (
    "Do without it: native_sim images that have no `ip` in the deployment file use this computer's own sockets."
)
