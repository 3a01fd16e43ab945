"""Without the laboratory, `farhand experiment` says what to install, and completes no names."""

import subprocess
import sys
from pathlib import Path

import pytest

from common.errors import NotInstalledError
from farhand.commands import laboratory
from farhand.commands.completion import experiment_names
from farhand.exits import MISUSE

WITHOUT = (
    "import importlib.metadata as m; m.entry_points = lambda **_: [];"
    "import farhand.commands.laboratory as l; l.entry_points = m.entry_points;"
    "from farhand.__main__ import main; main()"
)


def test_an_experiment_says_what_to_install(tmp_path: Path) -> None:
    words = ["experiment", "follow", "--out", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", WITHOUT, *words], capture_output=True, text=True, check=False)
    assert done.returncode == MISUSE
    assert done.stderr == f"farhand: {laboratory.CURE}\n"
    assert not (tmp_path / "out").exists()


def test_no_names_are_completed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(laboratory, "entry_points", lambda **_: [])
    with pytest.raises(NotInstalledError):
        laboratory.experiments()
    assert experiment_names("") == []
