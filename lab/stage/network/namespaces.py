"""Two hosts on this machine: this process and the remote site on one, the local site on the other, a link between.

Both call the remote site's host "localhost": sites without certificates speak to no other name.
"""

import ctypes
import fcntl
import json
import os
import struct
import subprocess
import tempfile
from pathlib import Path

from common.process.children import die_with_parent
from lab.stage.network.command_socket import send
from lab.stage.processes import ROOT, module_command
from lab.stage.waiting import until

CLONE_NEWNS, CLONE_NEWNET = 0x00020000, 0x40000000
MS_BIND, MS_REC, MS_PRIVATE = 4096, 16384, 1 << 18
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
HERE, THERE = "10.77.0.1", "10.77.0.2"
STDERR = 2
LIBC = ctypes.CDLL(None, use_errno=True)


def why_not() -> str:
    """Why this process may not have network namespaces and TUN devices; empty when it may."""
    if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        return "no right to /dev/net/tun"
    tried = subprocess.run(["unshare", "--net", "--mount", "true"], check=False, capture_output=True, text=True)
    return tried.stderr.strip()


class LinkedHosts:
    """The two hosts; `enter` moves this process to the first for good, `beyond` starts commands on the second."""

    def __init__(self) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="farhand-network-"))
        self._commands = self._folder / "link"
        self._processes: list[subprocess.Popen[bytes]] = []

    def enter(self) -> None:
        """Leave the machine's network for a host of its own, and connect the other one."""
        _check(LIBC.unshare(CLONE_NEWNET | CLONE_NEWNS))
        _check(LIBC.mount(None, b"/", None, MS_REC | MS_PRIVATE, None))
        hosts = self._folder / "hosts"
        hosts.write_text(f"{HERE} localhost\n")
        _check(LIBC.mount(str(hosts).encode(), b"/etc/hosts", None, MS_BIND, None))
        _ip("link set lo up")
        self._start("unshare", "--net", "sleep", "infinity")
        devices = [_tun("here"), _tun("there")]
        self._start(*module_command("lab.stage.network.link_shim", self._commands, *devices))
        _ip(f"addr add {HERE}/24 dev here")
        _ip("link set here up")
        other = self._processes[0].pid
        _wait_for_namespace(other)
        _ip(f"link set there netns {other}")
        for words in ("link set lo up", f"addr add {THERE}/24 dev there", "link set there up"):
            subprocess.run([*self.beyond, "ip", *words.split()], check=True)
        until(self._commands.exists, "the link")

    @property
    def beyond(self) -> tuple[str, ...]:
        """The words that begin a command on the other host."""
        return "nsenter", f"--net=/proc/{self._processes[0].pid}/ns/net"

    def impair(self, **fields: float) -> None:
        """Set what the link does from now on; without fields it is a good one."""
        send(self._commands, **fields)

    def report(self) -> list[dict[str, float]]:
        """Ask what the link has carried in each direction since the last report, and how late (see link_shim)."""
        report = self._folder / "report"
        send(self._commands, report=str(report))
        until(report.exists, "what the link has carried")
        figures: list[dict[str, float]] = json.loads(report.read_text())
        report.unlink()
        return figures

    @property
    def link_pid(self) -> int:
        """The process of the link."""
        return self._processes[1].pid

    def close(self) -> None:
        """End the other host and the link."""
        for process in reversed(self._processes):
            process.kill()
            process.wait()

    def _start(self, *command: str) -> None:
        parent = os.getpid()
        process = subprocess.Popen(
            command,
            close_fds=False,
            cwd=ROOT,
            stdout=STDERR,  # the output of who measures is read by programs
            preexec_fn=lambda: die_with_parent(parent),  # noqa: PLW1509  # two system calls that take no lock
        )
        self._processes.append(process)


def _tun(name: str) -> int:
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH14x", name.encode(), IFF_TUN | IFF_NO_PI))
    os.set_inheritable(device, True)
    return device


def _wait_for_namespace(pid: int) -> None:
    ours = os.readlink("/proc/self/ns/net")
    while os.readlink(f"/proc/{pid}/ns/net") == ours:
        os.sched_yield()


def _ip(words: str) -> None:
    subprocess.run(["ip", *words.split()], check=True)


def _check(result: int) -> None:
    if result != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
