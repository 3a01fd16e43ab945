"""Results of earlier runs on the mutants, kept in a file: a run that was ended goes on where it stopped."""

import ast
import hashlib
from functools import cache
from pathlib import Path

import msgspec

from lab.mutants.operators import Mutant
from lab.mutants.targets import Target


class Result(msgspec.Struct, frozen=True):
    """One line of the file; `name` is for those who read it."""

    key: str
    name: str
    survived: bool


class KnownResults:
    """The results by key; each is written as soon as it is known."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._survived = dict(_read(path))

    def survived(self, key: str) -> bool | None:
        """Return whether no test noticed the mutant; None where that has not been tried."""
        return self._survived.get(key)

    def note(self, result: Result) -> None:
        """Keep a result."""
        self._survived[result.key] = result.survived
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("ab") as file:
            file.write(msgspec.json.encode(result) + b"\n")


def key_of(target: Target, mutant: Mutant) -> str:
    """Names a mutant by its module as it is changed, and by what its tests say: another text is another mutant."""
    changed = ast.unparse(mutant.tree)
    return hashlib.sha256("\0".join([str(target.path), changed, _digest(target.tests)]).encode()).hexdigest()


@cache
def _digest(tests: tuple[Path, ...]) -> str:
    """Of all files of the tests."""
    files = [file for path in tests for file in ([path] if path.is_file() else sorted(path.rglob("*.py")))]
    return hashlib.sha256(b"\0".join(str(file).encode() + b"\0" + file.read_bytes() for file in files)).hexdigest()


def _read(path: Path) -> list[tuple[str, bool]]:
    """Read what a file holds; a last line that a killed run has left unfinished is none, and is cut off."""
    if not path.is_file():
        return []
    whole, _, unfinished = path.read_bytes().rpartition(b"\n")
    if unfinished:
        path.write_bytes(whole + b"\n" if whole else b"")
    results = [msgspec.json.decode(line, type=Result) for line in whole.splitlines()]
    return [(result.key, result.survived) for result in results]
