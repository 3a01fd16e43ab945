"""What the sites do works with the system calls that their units leave them: the same steps behind the same filter."""

import ctypes.util
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from farhand.loopback.site_process import free_ports

UNITS = Path(__file__).parents[2] / "farhand/deployment/systemd"
LIBRARY = ctypes.util.find_library("seccomp")
FILTER = """
import ctypes, errno, os, sys
ALLOW, REFUSE = 0x7FFF0000, 0x00050000 | errno.EPERM
seccomp = ctypes.CDLL(sys.argv[1])
seccomp.seccomp_init.restype = ctypes.c_void_p
context = ctypes.c_void_p(seccomp.seccomp_init(REFUSE))
for name in sys.argv[2].split():
    number = seccomp.seccomp_syscall_resolve_name(name.encode())
    if number >= 0:
        seccomp.seccomp_rule_add(context, ALLOW, number, 0)
if seccomp.seccomp_load(context) != 0:
    sys.exit("the filter could not be loaded")
try:
    os.chroot("/")
except PermissionError:
    print("filtered")
"""
SITE = """
import mmap, multiprocessing, os, sys
import numba
print("compiled", numba.njit(lambda x: x + 1)(1))

shared = mmap.mmap(-1, 8)
child = multiprocessing.get_context("fork").Process(target=lambda: shared.write(b"forked"))
child.start()
child.join()
print(bytes(shared[:6]).decode())

os.close(os.openpty()[1])
os.nice(5)
try:
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
except PermissionError:
    print("real time refused")
print("done")
"""

VIEWERS = """
import multiprocessing
from common.process.service import be_nice

def yields():
    be_nice(10)
    print("yielded", flush=True)

child = multiprocessing.get_context("fork").Process(target=yields)
child.start()
child.join()
"""

RECORDER = """
import sys
from datetime import UTC, datetime
from pathlib import Path

from common.link.transport import open_link
from common.process.log import LogFormat, start_log
from common.process.service import be_nice
from common.recording.config import OperatorRecordConfig
from common.recording.folder import make_private
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan
from local_site.config import LocalConfig, LocalLinksConfig
from local_site.recording.recorder import OperatorRecorder
from local_site.recording.source import OperatorSource

folder, remote, listen = Path(sys.argv[3]), *sys.argv[4:]
config = LocalConfig(links=LocalLinksConfig(remote=remote, listen=listen))
start_log("record", LogFormat.TEXT)
be_nice(5)
make_private(folder)
plan = RecordingPlan(folder, config.cell, "test", config.record)
with open_link(listen=(listen,)), OperatorSource(config) as source:
    recorder = OperatorRecorder(config, GuardedRecording(plan, lambda: datetime(2026, 3, 4, tzinfo=UTC)), source)
    for t_s in (1, 3):  # it flushes each second
        recorder.step(t_s * 10**9)
    print("writing" if recorder.state().writing else recorder.state().alarm)
    recorder.end(4 * 10**9)
print("done")
"""

pytestmark = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None or LIBRARY is None,
    reason="systemd-analyze or libseccomp is missing; on Debian: apt-get install systemd libseccomp2",
)


def filters_of(site: str) -> list[str]:
    """The values of SystemCallFilter, in order."""
    lines = (UNITS / f"farhand-{site}.service").read_text().splitlines()
    return [line.partition("=")[2] for line in lines if line.startswith("SystemCallFilter=")]


def expand(name: str) -> set[str]:
    """The system calls of a set, as systemd has them."""
    if not name.startswith("@"):
        return {name}
    told = subprocess.run(
        ["systemd-analyze", "syscall-filter", name], check=True, capture_output=True, text=True
    ).stdout
    words = [line.strip() for line in told.splitlines()[1:] if line.startswith("    ") and "#" not in line]
    return set().union(*map(expand, words))


def allowed(site: str) -> set[str]:
    calls: set[str] = set()
    for value in filters_of(site):
        names = value.removeprefix("~").split()
        sets = set().union(*map(expand, names))
        calls = calls - sets if value.startswith("~") else calls | sets
    return calls


def behind_the_filter(calls: set[str], program: str = SITE, *arguments: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", FILTER + program, str(LIBRARY), " ".join(sorted(calls)), *arguments],
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout.splitlines()


def may_have_real_time() -> bool:
    program = "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))"
    return subprocess.run([sys.executable, "-c", program], check=False, capture_output=True).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("site", ["remote", "local"])
def test_a_site_can_compile_fork_share_and_run_in_real_time(site: str) -> None:
    told = behind_the_filter(allowed(site))
    assert told[:3] == ["filtered", "compiled 2", "forked"]
    assert told[-1] == "done"
    assert ("real time refused" in told) is not may_have_real_time()


def test_the_router_can_start_a_process_that_yields_to_it() -> None:
    assert behind_the_filter(allowed("router"), VIEWERS) == ["filtered", "yielded"]


@pytest.mark.slow
def test_the_operators_recorder_can_listen_and_write(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    endpoints = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    told = behind_the_filter(allowed("record-local"), RECORDER, str(folder), *endpoints)
    assert told == ["filtered", "writing", "done"]
    assert len(list(folder.iterdir())) == 1


def test_real_time_would_be_missed_behind_the_consoles_filter() -> None:
    assert "real time refused" in behind_the_filter(allowed("console") | {"setpriority"})
