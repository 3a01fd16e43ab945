"""The bench of mutants: tests import what was changed, mutants stay the same, and a run that was ended goes on."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from lab.mutants import known, survivors
from lab.mutants.known import KnownResults, Result, key_of
from lab.mutants.operators import mutants_of
from lab.mutants.survivors import Job
from lab.mutants.targets import TARGETS, Target

ROOT = Path(__file__).parents[3]
SCRIPT = """
import ast
from functools import partial
from pathlib import Path
import remote_site.session.lease
from lab.mutants.operators import Mutant
from lab.mutants.survivors import PASSED, _start, _tested_with
from lab.mutants.targets import Target
path = Path("remote_site/session/lease.py")
target = Target(path, 1, (Path("tests/remote_site/session/test_lease.py"),))
for now in ("is None", "is not None"):
    source = path.read_text().replace("current is None", f"current {now}")
    process = _start(partial(_tested_with, target, Mutant("acquire", "current is None", now, ast.parse(source))))
    process.join()
    print("survives" if process.exitcode == PASSED else "noticed")
"""


@pytest.mark.slow
def test_a_change_of_a_module_that_is_loaded_already_is_seen_by_its_tests() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["survives", "noticed"]


SOURCE = "def larger(a, b):\n    return a if a > b and a > 0 else max(b, 1)\n"


@pytest.fixture
def jobs(tmp_path: Path) -> list[Job]:
    tests = tmp_path / "test_larger.py"
    tests.write_text("def test_larger(): ...\n")
    target = Target(Path("larger.py"), 5, (tests,))
    return [(target, mutant) for mutant in mutants_of(SOURCE, 5)]


def stand_in(monkeypatch: pytest.MonkeyPatch, most: int) -> list[Job]:
    """Mutants that are not really run, and of which each second one survives; the run is ended after `most`."""
    tried: list[Job] = []

    def run_them(jobs: list[Job], _usual_s: object) -> Iterator[tuple[Job, bool]]:
        for job in jobs:
            if len(tried) == most:
                raise KeyboardInterrupt
            tried.append(job)
            yield job, len(tried) % 2 == 0

    monkeypatch.setattr(survivors, "_run", run_them)
    monkeypatch.setattr(survivors, "_time_unchanged", lambda _tests: 0.0)
    known._digest.cache_clear()
    return tried


def test_a_run_that_was_ended_goes_on_where_it_stopped(
    jobs: list[Job], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "build" / "mutants.jsonl"
    first = stand_in(monkeypatch, 3)
    with pytest.raises(KeyboardInterrupt):
        survivors.find_survivors(jobs, KnownResults(file))
    assert first == jobs[:3]
    with file.open("a") as lines:
        lines.write('{"key": "it was killed while it wr')
    second = stand_in(monkeypatch, 100)
    assert survivors.find_survivors(jobs, KnownResults(file)) == [jobs[1], jobs[4]]
    assert second == jobs[3:]
    third = stand_in(monkeypatch, 100)
    assert survivors.find_survivors(jobs, KnownResults(file)) == [jobs[1], jobs[4]]
    assert third == []


def test_another_change_of_the_file_or_of_its_tests_is_tried_anew(jobs: list[Job], tmp_path: Path) -> None:
    results = KnownResults(tmp_path / "mutants.jsonl")
    target, mutant = jobs[0]
    results.note(Result(key_of(target, mutant), "larger", survived=True))
    assert results.survived(key_of(target, mutant)) is True
    assert results.survived(key_of(target, jobs[1][1])) is None
    assert results.survived(key_of(target, mutants_of(SOURCE.replace("max", "abs"), 5)[0])) is None
    target.tests[0].write_text("def test_larger(): assert 1\n")
    known._digest.cache_clear()
    assert results.survived(key_of(target, mutant)) is None


def test_the_choice_of_mutants_is_the_same_at_every_start() -> None:
    script = (
        "from lab.mutants.survivors import TARGETS, _mutants, key_of\n"
        "print(*(key_of(target, mutant) for target in TARGETS[:4] for mutant in _mutants(target)))"
    )
    starts = [
        subprocess.run(
            [sys.executable, "-c", script],
            cwd=ROOT,
            env={"PYTHONPATH": str(ROOT), "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert len(starts[0].split()) == sum(target.mutants for target in TARGETS[:4])
    assert starts[0] == starts[1]


def test_every_target_and_each_of_its_tests_are_there() -> None:
    missing = [path for target in TARGETS for path in (target.path, *target.tests) if not (ROOT / path).exists()]
    assert missing == []
    assert len({target.path for target in TARGETS}) == len(TARGETS)
