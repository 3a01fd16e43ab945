"""The loopback recorded and exported: its dataset has the pictures and the actions of the recording."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from farhand.export.recording import open_sessions
from farhand.export.resampling import instants
from farhand.export.session import newest_index
from farhand.export.videos.h264 import decoded
from tests.farhand.export.lerobot.made_dataset import FPS, episodes, export, frames, pictures
from tests.loopback.undisturbed import PATIENT


@pytest.mark.long  # a recorded site on stepped time covers the same ground in tests/farhand/export
def test_the_dataset_of_a_loopback_is_its_recording(tmp_path: Path) -> None:
    file, out = tmp_path / "run.mcap", tmp_path / "dataset"
    command = ["loopback", "--seconds", "9", "--headless", "--motion", "toggles", *PATIENT, "--record", str(file)]
    done = subprocess.run(
        [sys.executable, "-m", "farhand", *command], check=False, capture_output=True, text=True, timeout=240
    )
    assert done.returncode == 0, done.stderr
    with open_sessions([file]) as sessions:
        (session,) = sessions
        export(sessions, out)
        signals = session.signals()
        first = session.facts.episodes[0]
        rows, row = frames(out), episodes(out)[0]
        at = instants(first.begin_ns, first.end_ns, FPS)[-row["length"] :]
        sent = signals.actions.motion
        joints = len(session.facts.joint_names)
        np.testing.assert_allclose(
            np.array(rows["action"])[: row["length"], :joints], sent.values[newest_index(sent.t_ns, at)], atol=1e-6
        )
        assert len(session.facts.views) == 4
        for view in session.facts.views:
            kept = [one for one in session.pictures(first.begin_ns - 10**9, first.end_ns) if one.view == view]
            shown = pictures(out, view, 0.0, row["length"] / FPS)
            assert len(shown) == row["length"]
            exposed = np.array([one.capture_ns for one in kept])
            for picture, instant in ((shown[0], at[0]), (shown[-1], at[-1])):
                source = decoded(kept[newest_index(exposed, np.array([instant]))[0]].jpeg, view)
                assert np.abs(picture.astype(int) - source).mean() < 4
