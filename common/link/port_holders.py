"""Who has a port or a device of this host, from /proc; processes of other users may remain unknown."""

import errno
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

PROC = Path("/proc")
LISTENING = {"tcp": "0A", "tcp6": "0A", "udp": "07", "udp6": "07"}  # the state of a socket that waits, by its table


def listener_on(port: int) -> str:
    """Return name and number of the process that listens on a port of this host; empty if none is visible."""
    sockets = set()
    for name, waiting in LISTENING.items():
        table = PROC / "net" / name
        lines = table.read_text().splitlines()[1:] if table.exists() else []
        for fields in map(str.split, lines):
            if fields[3] == waiting and int(fields[1].rpartition(":")[2], 16) == port:
                sockets.add(f"socket:[{fields[9]}]")
    return _holder_of(sockets)


def why_not_bound(error: OSError, port: int, another: str = "another") -> str:
    """Say why a port cannot be listened on, with the program that has it; `another` is how to choose another port."""
    if error.errno != errno.EADDRINUSE:
        return f"{error.strerror or error}; choose {another}"
    return f"{listener_on(port) or 'a program that this user may not see'} has this port; end it, or choose {another}"


def holder_of_device(path: Path) -> str:
    """Return name and number of a process that has a device open; empty without one."""
    return _holder_of({str(path.resolve())})


def is_ours(holder: str) -> bool:
    """Return whether a process by this name is one of Farhand's."""
    return holder.startswith("farhand")


def _holder_of(targets: set[str]) -> str:
    for process in PROC.iterdir():
        if process.name.isdecimal() and not targets.isdisjoint(_open_files(process)):
            with suppress(OSError):  # ended meanwhile
                return f"{_name_of(process)} (process {process.name})"
    return ""


def _open_files(process: Path) -> Iterator[str]:
    try:
        handles = sorted((process / "fd").iterdir())
    except OSError:  # it has ended, or is another user's
        return
    for handle in handles:
        with suppress(OSError):  # closed meanwhile
            yield str(handle.readlink())


def _name_of(process: Path) -> str:
    """Return the name that `ps` shows, but for Farhand started as a module, which would be called python there."""
    command = (process / "cmdline").read_bytes()
    name = (process / "comm").read_text(errors="replace").strip()  # 15 bytes, which may end within a letter
    return "farhand" if name.startswith("python") and b"\0-m\0farhand\0" in command else name
