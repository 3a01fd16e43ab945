"""A whole setup: from cameras to a configuration that loads, left in the middle and taken up again."""

import dataclasses
import json
import os
from contextlib import contextmanager
from functools import lru_cache

import numpy as np
import pytest
from msgspec.structs import replace

from common.cameras.settings import CameraSettings
from common.config.loading import load_config
from common.errors import ConfigError, InterruptionError
from farhand.deployment.schemas import schema_of
from farhand.setup.conversation import TerminalPerson
from farhand.setup.notes import SetupAnswers, SetupFolder
from farhand.setup.steps import Tools, set_up
from local_site.calibration.boards import BoardFinder
from local_site.calibration.rig_file import load_rig, save_rig
from local_site.config import LocalConfig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from tests.farhand.setup.board_cameras import BoardCamera
from tests.farhand.setup.operator_views import FilmedCamera, filmed, views_of
from tests.farhand.setup.scripted_person import ScriptedPerson, no_bar
from tests.present import present

NO_TRIAL = {"Try the tracker": "n"}
SCRIPT = {"rulers": "", "ruler": "98.5", "left, seen": "1", **NO_TRIAL}


@pytest.fixture(autouse=True)
def _boards_are_found_once(monkeypatch):
    """A board that is held still gives the same picture several times."""
    find, found_in = BoardFinder.find, {}

    def find_once(finder, picture):
        key = hash(picture.tobytes())
        if key not in found_in:
            found_in[key] = find(finder, picture)
        return found_in[key]

    monkeypatch.setattr(BoardFinder, "find", find_once)


def tools(cameras=BoardCamera, views=None):
    return Tools(
        find=lambda: ["fake://a", "fake://broken", "fake://b"],
        modes=lambda _source: (),
        open=cameras,
        views=views or (lambda *_: iter(())),
        progress=no_bar,
    )


@pytest.mark.slow
def test_cameras_become_a_calibrated_configuration(tmp_path):
    person = ScriptedPerson(SCRIPT)
    set_up(tmp_path, person, tools())
    config = load_config(LocalConfig, tmp_path / "local.toml")
    assert config.operator.sources == ("fake://a", "fake://b")
    assert config.operator.cameras == CameraSettings(width_px=640, height_px=480, fps=30.0)
    rig = load_rig(tmp_path / "rig.json")
    assert all(camera.reprojection_rms_px < 0.2 for camera in rig.cameras)
    centres = [-np.linalg.solve(m[:, :3], m[:, 3]) for m in rig.matrices]
    true_mm = 1000 * 2 * 0.9 * np.cos(np.arctan(0.8)) * np.sin(np.radians(20))
    assert 1000 * np.linalg.norm(centres[1] - centres[0]) == pytest.approx(0.985 * true_mm, abs=3.0)
    made = {path.name for path in tmp_path.iterdir()}
    assert made >= {"answers.json", "thumbnails", "board.pdf", "calibration", "found", "rig.json", "local.toml"}
    assert person.heard("cannot open fake://broken")
    assert person.heard("that is enough")
    assert person.told[-1] == f"start the local site with: farhand local --config {tmp_path / 'local.toml'}"
    named = (tmp_path / "local.toml").read_text().partition("\n")[0].removeprefix("#:schema ")
    assert json.loads((tmp_path / named).read_text()) == json.loads(json.dumps(schema_of(LocalConfig)))


@pytest.mark.slow
def test_a_setup_that_was_left_keeps_its_pairs_and_goes_on(tmp_path):
    class Interrupted(BoardCamera):
        """Ctrl-C comes with a frame of the fifth pose."""

        def read(self):
            frame = super().read()
            if self.name == "right" and present(frame).seq == 30:
                raise KeyboardInterrupt
            return frame

    with pytest.raises(InterruptionError, match=f"go on with: farhand setup --out {tmp_path}"):
        set_up(tmp_path, ScriptedPerson(SCRIPT), tools(Interrupted))
    kept = sorted((tmp_path / "calibration" / "left").iterdir())
    assert len(kept) == 3
    first = kept[0].read_bytes()
    (tmp_path / "calibration" / "left" / "009.png").write_bytes(first)  # its pair was not written any more
    person = ScriptedPerson(SCRIPT)
    set_up(tmp_path, person, tools())
    assert any("Keep the cameras, left fake://a, right fake://b?" in question for question in person.asked)
    assert any("3 pairs of an earlier run are there" in question for question in person.asked)
    assert not any("level at first" in question for question in person.asked), "the first pair is there"
    assert kept[0].read_bytes() == first
    assert load_rig(tmp_path / "rig.json")


@pytest.mark.parametrize("pictures", [0, 3])
def test_cameras_that_end_before_the_first_pair_are_told_and_nothing_is_counted(tmp_path, pictures):
    class Ending(BoardCamera):
        """Ends early once the board is to be shown."""

        def read(self):
            taking = (tmp_path / "board.pdf").exists()
            return None if taking and self._seq >= pictures else super().read()

    shown = []

    @contextmanager
    def bar():
        yield lambda *counts: shown.append(counts)

    person = ScriptedPerson({**SCRIPT, "What now?": [InterruptionError("left")]})
    with pytest.raises(InterruptionError, match="left"):
        set_up(tmp_path, person, dataclasses.replace(tools(Ending), progress=bar))
    assert person.heard("a camera came to its end before a pair was kept: give cameras that run")
    assert not person.heard("missing")
    assert shown == []


def prepared(tmp_path):
    """A folder whose cameras and rig are the simulated operator's."""
    size = CameraSettings(width_px=640, height_px=480)
    answers = SetupAnswers(left="a", right="b", cameras=size, square_mm=30.0, method="silhouette")
    folder = SetupFolder(tmp_path)
    folder.keep(replace(answers, rig_by=answers.rig_needs))
    save_rig(exact_rig(SimulationConfig().stereo), folder.rig)
    return folder


film = lru_cache(filmed)


def test_what_is_there_is_kept_and_the_configured_tracker_is_tried(tmp_path):
    prepared(tmp_path)
    opened = []

    def camera(source, name, settings):
        opened.append((source, name, settings.size_px))
        return FilmedCamera(name, [])

    person = ScriptedPerson({"Try the tracker": ["y", "n"]})
    set_up(tmp_path, person, tools(camera, lambda _cameras, _pairing, _seconds: views_of(film(30))))
    assert opened == [("a", "left", (640, 480)), ("b", "right", (640, 480))]
    assert any(sentence.startswith("ok       tracked: ") for sentence in person.told)
    assert person.heard("elbow in view: left 100 %, right 100 %")


def test_a_camera_that_fails_in_the_trial_is_told_and_the_trial_offered_again(tmp_path):
    prepared(tmp_path)  # its cameras are none of the board's
    person = ScriptedPerson({"Try the tracker": ["y", "n"]})
    set_up(tmp_path, person, tools())
    assert person.heard("camera left: cannot open a")
    assert person.told[-1].startswith("start the local site")


def test_another_board_needs_another_calibration(tmp_path):
    folder = prepared(tmp_path)
    person = ScriptedPerson({"printed board": "n", "ruler": "97", "level at first": [InterruptionError("left")]})
    with pytest.raises(InterruptionError):
        set_up(tmp_path, person, tools())
    assert person.heard("was made with other cameras, another size or another board: calibrate again")
    assert folder.rig.exists()


def test_pairs_of_other_cameras_are_put_aside(tmp_path):
    folder = prepared(tmp_path)
    folder.keep(replace(folder.answers(), rig_by=None, pairs_by="others"))
    (folder.pictures("left")).mkdir(parents=True)
    (folder.pictures("left") / "001.png").write_bytes(b"a picture")
    with pytest.raises(InterruptionError):
        set_up(tmp_path, ScriptedPerson({"level at first": [InterruptionError("left")]}), tools())
    assert (tmp_path / "calibration.old" / "left" / "001.png").read_bytes() == b"a picture"


@pytest.mark.parametrize("keep", ["y", "n"])
def test_an_edited_configuration_is_kept_or_put_aside_never_lost(tmp_path, keep):
    folder = prepared(tmp_path)
    set_up(tmp_path, ScriptedPerson(NO_TRIAL), tools())
    edited = folder.configuration.read_text() + '\n[smoothing]\nmethod = "mean"\n'
    folder.configuration.write_text(edited)
    set_up(tmp_path, ScriptedPerson({**NO_TRIAL, "differs": keep}), tools())
    holder = folder.configuration if keep == "y" else tmp_path / "local.toml.old"
    assert holder.read_text() == edited
    assert load_config(LocalConfig, folder.configuration).tracking.method == "silhouette"


@pytest.mark.parametrize(("left", "others_read"), [("a", True), ("rtsp://anna:s3cret@192.0.2.7/x", False)])
def test_nobody_else_reads_a_cameras_password_in_what_a_setup_writes(tmp_path, left, others_read):
    folder = prepared(tmp_path)
    answers = replace(folder.answers(), left=left)
    folder.keep(replace(answers, rig_by=answers.rig_needs))
    for name in ("answers.json", "local.toml"):
        (tmp_path / name).touch()
        (tmp_path / name).chmod(0o644)  # as an earlier release left them
    umask = os.umask(0o022)
    try:
        set_up(tmp_path, ScriptedPerson({**NO_TRIAL, "differs": "n"}), tools())
    finally:
        os.umask(umask)
    open_to_others = {path.name for path in tmp_path.iterdir() if path.stat().st_mode & 0o077}
    assert not {"answers.json", "local.toml.old"} & open_to_others
    assert ("local.toml" in open_to_others) == others_read


def test_without_a_terminal_there_is_a_clear_error(monkeypatch):
    monkeypatch.setattr("sys.stdin.isatty", lambda: False)
    with pytest.raises(ConfigError, match="needs a terminal"):
        TerminalPerson()
