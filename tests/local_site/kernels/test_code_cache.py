"""Compiled code is stale once any file with compiled functions has changed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from local_site.kernels.code_cache import digest_of_sources
from local_site.kernels.pictures import grey_at
from tests.present import present

PROGRAM = "import local_site.inner, local_site.outer; print(local_site.outer.twice())"
NO_ROOM = (
    "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
    "resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64)); "
)
INNER = "from local_site.kernels.compiled import compiled\nSIZE = {size}\n@compiled\ndef once():\n    return SIZE\n"
OUTER = (
    "from local_site.kernels.compiled import compiled\nfrom local_site.inner import SIZE, once\n"
    "@compiled\ndef twice():\n    return SIZE + once()\n"
)


@pytest.fixture
def package(tmp_path):
    """A package of two files with compiled functions, and the kernels of this one."""
    folder = tmp_path / "local_site"
    (folder / "kernels").mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "kernels/__init__.py").touch()
    for name in ("compiled.py", "code_cache.py"):
        (folder / "kernels" / name).write_bytes(
            (Path(present(sys.modules[grey_at.__module__].__file__)).parent / name).read_bytes()
        )
    (folder / "inner.py").write_text(INNER.format(size=1))
    (folder / "outer.py").write_text(OUTER)
    return folder


def ran(package):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=package.parent,
        # Python tells a changed file by whole seconds: no bytecode is kept of one that the test changes.
        env={**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return int(done.stdout)


@pytest.mark.slow
def test_a_constant_changed_in_another_file_is_noticed(package):
    assert ran(package) == 2
    (package / "inner.py").write_text(INNER.format(size=7))
    assert ran(package) == 14


@pytest.mark.slow
def test_unchanged_sources_are_not_compiled_again(package):
    ran(package)
    kept = {path: path.stat().st_mtime_ns for path in package.rglob("*.nb?")}
    assert len(kept) == 4
    (package / "kernels/__init__.py").write_text("# nothing compiled here\n")
    ran(package)
    assert {path: path.stat().st_mtime_ns for path in package.rglob("*.nb?")} == kept


def test_only_files_with_compiled_functions_count(tmp_path):
    (tmp_path / "loop.py").write_text("@compiled\ndef loop(): ...\n")
    before = digest_of_sources(tmp_path)
    (tmp_path / "plain.py").write_text("def plain(): ...\n")
    assert digest_of_sources(tmp_path) == before
    (tmp_path / "other.py").write_text("@compiled\ndef other(): ...\n")
    assert digest_of_sources(tmp_path) != before


def test_code_that_cannot_be_kept_is_used_all_the_same_and_that_is_said_once(package):
    """A full disk used to end the tracker with a bare OSError, at the first call of whatever was not kept yet."""
    done = subprocess.run(
        [sys.executable, "-c", NO_ROOM + PROGRAM],
        cwd=package.parent,
        env={**os.environ, "PYTHONPATH": str(package.parent)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert (done.returncode, done.stdout) == (0, "2\n"), done.stderr
    assert done.stderr.count("RuntimeWarning: compiled code cannot be kept") == 1
    assert "File too large" in done.stderr
