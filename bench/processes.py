"""The cost of a process, from /proc."""

import os
from pathlib import Path

from common.errors import ProcessError

KB_PER_MB = 1024


def cpu_s(pid: int) -> float:
    """The processor time that a process has used so far, without its children, s."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid: int) -> float:
    """The resident memory of a process, MB."""
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmRSS")) / KB_PER_MB


def child_of(pid: int, name: str) -> int:
    """The child process of this name; ProcessError without one."""
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            fields = (entry / "stat").read_text(encoding="utf-8").rpartition(")")
            if fields[2].split()[1] == str(pid) and fields[0].endswith(f"({name}"):
                return int(entry.name)
    raise ProcessError(f"process {pid} has no child {name}")
