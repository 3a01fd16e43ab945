"""The bench of mutants has the tests import what it changed, although it has loaded that module itself before."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = """
import ast
from functools import partial
from pathlib import Path
import remote_site.session.lease
from bench.mutants.operators import Mutant
from bench.mutants.run import PASSED, _start, _tested_with
from bench.mutants.targets import Target
path = Path("remote_site/session/lease.py")
target = Target(path, 1, (Path("tests/remote_site/session/test_lease.py"),))
for now in ("is None", "is not None"):
    source = path.read_text().replace("current is None", f"current {now}")
    process = _start(partial(_tested_with, target, Mutant("acquire", "current is None", now, ast.parse(source))))
    process.join()
    print("survives" if process.exitcode == PASSED else "noticed")
"""


@pytest.mark.long
def test_a_change_of_a_module_that_is_loaded_already_is_seen_by_its_tests() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["survives", "noticed"]
