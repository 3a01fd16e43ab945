"""Plots without a display or global state, and an experiment where matplotlib is missing."""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from farhand.reports.plotting import describe_panel, panels, png, widen
from tests.present import present

WITHOUT_MATPLOTLIB = (
    "import sys; sys.modules['matplotlib'] = None; sys.argv[0] = 'farhand';from farhand.__main__ import main; main()"
)
NO_PYPLOT = (
    "import sys; from farhand.reports.plotting import panels, png;"
    "png(*panels('nothing', 1), 'frame'); sys.exit('matplotlib.pyplot' in sys.modules)"
)
RED = {"color": "#ff0000", "linewidth": 3.0}


def red_columns(content: bytes) -> list[int]:
    """The numbers of the picture's columns with the curve's colour in them."""
    picture = present(cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR))
    return [int(column) for column in np.flatnonzero((picture == (0, 0, 255)).all(axis=2).any(axis=0))]


def drawn(values: list[float]) -> bytes:
    figure, axes = panels("title", 1)
    axes[0, 0].plot(np.array(values), **RED)
    describe_panel(axes[0, 0], "panel", "y, mm")
    return png(figure, axes, "frame")


def test_a_curve_is_broken_where_it_is_not_a_number() -> None:
    whole, broken = red_columns(drawn([1.0] * 10)), red_columns(drawn([1.0] * 4 + [np.nan] + [1.0] * 5))
    assert max(np.diff(whole)) == 1
    assert max(np.diff(broken)) > 0.1 * len(whole)


def test_the_same_curves_give_the_same_picture() -> None:
    assert drawn([1.0, 3.0, 2.0]) == drawn([1.0, 3.0, 2.0])


def test_an_axis_is_widened_about_its_middle_and_never_narrowed() -> None:
    axes = panels("title", 1)[1][0, 0]
    axes.set_ylim(4.0, 6.0)
    widen(axes, 10.0)
    assert axes.get_ylim() == (0.0, 10.0)
    widen(axes, 3.0)
    assert axes.get_ylim() == (0.0, 10.0)


def test_nothing_is_drawn_by_way_of_a_display() -> None:
    assert subprocess.run([sys.executable, "-c", NO_PYPLOT], check=False, timeout=60).returncode == 0


@pytest.mark.slow
def test_without_matplotlib_an_experiment_names_the_extra_before_any_work(tmp_path: Path) -> None:
    command = [sys.executable, "-c", WITHOUT_MATPLOTLIB, "experiment", "drift", "--out", str(tmp_path / "out")]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "pip install 'farhand[experiments]'" in done.stderr
    assert not (tmp_path / "out").exists()
