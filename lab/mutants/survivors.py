"""Runs the tests on every mutant, each in a process of its own, and lists those that no test notices.

What is found is kept in a file: a second start tries only what is not known yet.
"""

import importlib.abc
import importlib.machinery
import importlib.util
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import CodeType, ModuleType

import msgspec  # noqa: F401  # loaded once, before the processes fork
import numpy as np  # noqa: F401  # the same
import pinocchio  # noqa: F401  # the same
import pytest
import ruckig  # noqa: F401  # the same

from lab.mutants.explained import EXPLAINED
from lab.mutants.known import KnownResults, Result, key_of
from lab.mutants.operators import Mutant, mutants_of
from lab.mutants.targets import EDGES, TARGETS, Target

KNOWN = Path("build") / "mutants.jsonl"
AT_ONCE = 2
LONGEST_S, TIMES = 240.0, 4.0  # a mutant whose tests take longer than both, the latter beside no mutant, never ends
OURS = ("common", "farhand", "lab", "local_site", "remote_site")
POLL_S = 0.05
PASSED = 0
ALONE = ("--disable-plugin-autoload", "-p", "pytest_timeout", "-p", "no:cacheprovider")
OPTIONS = ("-x", "-q", *ALONE, "-m", "not long and not faults")


class ChangedModule(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one module from a changed tree; its lines are those of the file."""

    def __init__(self, name: str, path: Path, code: CodeType) -> None:
        self._name, self._path, self._code = name, path, code

    def find_spec(
        self, name: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """The changed module's, None for any other."""
        if name != self._name:
            return None
        return importlib.util.spec_from_file_location(name, self._path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        """Run the changed code."""
        exec(self._code, module.__dict__)  # noqa: S102  # our own code, with one change


Job = tuple[Target, Mutant]


def measure() -> dict[str, float]:
    """Run every mutant; the survivors are printed, those without an explanation first."""
    jobs = [(target, mutant) for target in TARGETS for mutant in _mutants(target)]
    known = KnownResults(KNOWN)
    at_the_edges = [(target._replace(tests=EDGES), mutant) for target, mutant in find_survivors(jobs, known)]
    survivors = [f"{target.path}:{mutant}" for target, mutant in find_survivors(at_the_edges, known)]
    unexplained = [each for each in survivors if each not in EXPLAINED]
    for each in unexplained:
        print(f"SURVIVES {each}")
    for each in sorted(set(survivors) & set(EXPLAINED)):
        print(f"explained {each}: {EXPLAINED[each]}")
    for each in sorted(set(EXPLAINED) - set(survivors)):
        print(f"explained, but killed or not made any more: {each}")
    return {
        "mutants": float(len(jobs)),
        "killed": float(len(jobs) - len(survivors)),
        "explained": float(len(survivors) - len(unexplained)),
        "unexplained": float(len(unexplained)),
    }


def find_survivors(jobs: list[Job], known: KnownResults) -> list[Job]:
    """The mutants that no test notices; those that are known already are not run again."""
    keys = [key_of(*job) for job in jobs]
    unknown = [job for key, job in zip(keys, jobs, strict=True) if known.survived(key) is None]
    print(f"{len(jobs) - len(unknown)} of {len(jobs)} mutants are known from a run before", flush=True)
    usual_s = {tests: _time_unchanged(tests) for tests in dict.fromkeys(target.tests for target, _ in unknown)}
    for (target, mutant), survived in _run(unknown, usual_s):
        known.note(Result(key_of(target, mutant), f"{target.path}:{mutant}", survived))
    return [job for key, job in zip(keys, jobs, strict=True) if known.survived(key)]


def _mutants(target: Target) -> list[Mutant]:
    return mutants_of(target.path.read_text(encoding="utf-8"), target.mutants)


def _time_unchanged(tests: tuple[Path, ...]) -> float:
    """Measure how long the tests take, s; exit where they fail without a change, as they would notice every mutant."""
    begun = time.monotonic()
    process = _start(partial(_tested, tests))
    process.join()
    if process.exitcode != PASSED:
        sys.exit(f"these tests fail without any change: {' '.join(map(str, tests))}")
    return time.monotonic() - begun


def _run(jobs: list[Job], usual_s: dict[tuple[Path, ...], float]) -> Iterator[tuple[Job, bool]]:
    """Every mutant once its tests have ended, and whether they passed; `usual_s` is how long they take otherwise."""
    waiting, running = list(reversed(jobs)), dict[BaseProcess, tuple[Target, Mutant, float]]()
    while waiting or running:
        while waiting and len(running) < AT_ONCE:
            target, mutant = waiting.pop()
            process = _start(partial(_tested_with, target, mutant))
            running[process] = target, mutant, time.monotonic()
        time.sleep(POLL_S)
        for process, (target, mutant, begun) in list(running.items()):
            if process.is_alive() and time.monotonic() - begun > max(LONGEST_S, TIMES * usual_s[target.tests]):
                process.kill()  # it never ends: noticed
            if not process.is_alive():
                del running[process]
                yield (target, mutant), process.exitcode == PASSED


def _start(main: Callable[[], int]) -> BaseProcess:
    process = multiprocessing.get_context("fork").Process(target=lambda: os._exit(main()))
    process.start()
    return process


def _tested_with(target: Target, mutant: Mutant) -> int:
    for loaded in [name for name in sys.modules if name.partition(".")[0] in OURS]:
        del sys.modules[loaded]  # else nothing would import the changed module
    name = ".".join(target.path.with_suffix("").parts)
    code = compile(mutant.tree, str(target.path.resolve()), "exec")
    sys.meta_path.insert(0, ChangedModule(name, target.path, code))
    return _tested(target.tests)


def _tested(tests: tuple[Path, ...]) -> int:
    """The exit code of the tests, without their output."""
    with Path(os.devnull).open("w") as nowhere:
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
        return int(pytest.main([*OPTIONS, *map(str, tests)]))
