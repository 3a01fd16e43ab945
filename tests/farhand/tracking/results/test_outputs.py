"""Where a track may go: what cannot be written is refused before any work, with the cure."""

import subprocess
import sys
from pathlib import Path

import pytest

from common.errors import ConfigError
from farhand.tracking.results.outputs import TrackOutputs

WITHOUT_MATPLOTLIB = (
    "import sys; sys.modules['matplotlib'] = None; sys.argv[0] = 'farhand';from farhand.__main__ import main; main()"
)


@pytest.mark.parametrize(
    ("options", "cure"),
    [
        ({"annotate": "overlay.mp4"}, r"--annotate .*a folder for pictures; for a video give --video .*overlay\.mp4"),
        ({"annotate": "overlay.avi"}, r"for a video give --video .*overlay\.mp4"),
        ({"report": "report.html"}, r"--report .*give a folder"),
        ({"video": "overlay.avi"}, r"--video .*ends in \.mp4"),
        ({"video": "absent/overlay.mp4"}, r"--video .*a folder that exists"),
        ({"csv": "absent/track.csv"}, r"--csv .*a folder that exists"),
        ({"csv": "track.jsonl"}, r"--out and --csv are both"),
        ({"report": "same", "annotate": "same"}, r"--annotate and --report are both"),
        ({"csv": "rig.json"}, r"--csv .*would overwrite what is read"),
    ],
)
def test_a_place_that_does_not_serve_is_refused(tmp_path: Path, options: dict[str, str], cure: str) -> None:
    (tmp_path / "rig.json").touch()
    outputs = TrackOutputs(tmp_path / "track.jsonl", **{name: tmp_path / place for name, place in options.items()})
    with pytest.raises(ConfigError, match=cure):
        outputs.check([tmp_path / "rig.json"])
    assert [path.name for path in tmp_path.iterdir()] == ["rig.json"]


def test_a_folder_may_have_a_dot_in_its_name_where_it_exists_or_is_a_number(tmp_path: Path) -> None:
    (tmp_path / "pictures.d").mkdir()
    TrackOutputs(tmp_path / "track.jsonl", tmp_path / "pictures.d", report=tmp_path / "2026.11.23").check([])


def test_a_name_in_capitals_is_a_video_too(tmp_path: Path) -> None:
    TrackOutputs(tmp_path / "track.jsonl", video=tmp_path / "OVERLAY.MP4").check([])


@pytest.mark.slow
def test_without_matplotlib_a_report_names_the_extra_before_any_work(tmp_path: Path) -> None:
    track = ["track", "--rig", "absent.json", "--left", "a", "--right", "b", "--out", str(tmp_path / "track.jsonl")]
    command = [sys.executable, "-c", WITHOUT_MATPLOTLIB, *track, "--report", str(tmp_path / "report")]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "plots need matplotlib" in done.stderr
    assert "pip install 'farhand[experiments]'" in done.stderr
    assert not list(tmp_path.iterdir())
