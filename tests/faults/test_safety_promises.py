"""Every promise in docs/safety.md names its hazard, the fault row and the tests that hold it, and they exist."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.faults.fault_rows import ROWS

TESTS = Path(__file__).parents[1]
DOCUMENT = TESTS.parent / "docs" / "safety.md"
HEAD = ["hazard", "what happens", "the arm", "and then", "held by"]
FAULTS = {row.fault for row in ROWS}


def promises() -> list[list[str]]:
    """The cells of the table under "What is promised", without its head."""
    _, section = DOCUMENT.read_text(encoding="utf-8").split("## What is promised\n")
    lines = [line for line in section.split("\n## ")[0].splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert rows[0] == HEAD
    return rows[2:]


@cache
def functions_of(path: Path) -> set[str]:
    """The test functions of a file."""
    return {node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("row", promises(), ids=lambda row: row[1][:50])
def test_a_promise_names_what_holds_it(row: list[str]) -> None:
    assert len(row) == len(HEAD)
    assert all(row)
    faults, named = re.findall(r'"([^"]+)"', row[-1]), re.findall(r"`([^`]+)`", row[-1])
    assert faults
    assert set(faults) <= FAULTS
    assert named
    for test in named:
        file, _, function = test.partition("::")
        assert function in functions_of(TESTS / file), test


def test_there_are_promises() -> None:
    assert len(promises()) >= 30
