"""MediaPipe's landmarks in space: those of both views to points, the child's answers, and why there are none."""

import sys

import numpy as np
import pytest

from common.cameras.camera import Frame
from lab.measure.tracking.mediapipe_hands import MediaPipeHands, install, triangulate_landmarks
from lab.stage.processes import UnavailableError, reason
from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.tracker import View, Views

RIG = exact_rig(StereoConfig())
SIZE = (640, 480)
PLACES = {"wrist": [0.5, 0.45, 0.6], "thumb": [0.42, 0.4, 0.66], "index": [0.4, 0.45, 0.68]}
NUMBERS = {"wrist": 0, "thumb": 4, "index": 8}


def hands():
    """Both views' landmarks of PLACES, as fractions of the picture."""
    views = []
    for matrix in RIG.matrices:
        marks = np.full((21, 2), 0.5)
        for name, place in PLACES.items():
            marks[NUMBERS[name]] = project(matrix, np.array(place)) / SIZE
        views.append(tuple((x, y) for x, y in marks.tolist()))
    return views


def views(value=0):
    picture = np.full((480, 640), value, np.uint8)
    return Views(0, (View(Frame(picture, 0, 0)), View(Frame(picture, 0, 0))))


def child(tmp_path, body):
    """A MediaPipe whose Python ignores the script it is given and does this instead."""
    (tmp_path / "python").write_text(f"#!{sys.executable}\nimport sys, json\n{body}\n")
    (tmp_path / "python").chmod(0o755)
    return MediaPipeHands(tmp_path / "python", tmp_path)


def test_landmarks_are_triangulated_by_the_rig():
    points = triangulate_landmarks(RIG, hands(), [SIZE, SIZE])
    assert {name: pytest.approx(place, abs=1e-6) for name, place in PLACES.items()} == points


def test_a_hand_in_one_view_only_is_no_result():
    assert triangulate_landmarks(RIG, [hands()[0], None], [SIZE, SIZE]) == {}


def test_the_pictures_go_to_the_child_and_landmarks_come_back(tmp_path):
    body = f"""
head = json.loads(sys.stdin.buffer.readline())
data = sys.stdin.buffer.read(2 * 480 * 640)
right = head == {{"scene": "yz", "shapes": [[480, 640], [480, 640]]}} and set(data) == {{7}}
answer = {{"wall_ms": 3.0, "processor_ms": 2.0, "hands": {[[list(m) for m in h] for h in hands()]!r}}}
print(json.dumps(answer) if right else "wrong", flush=True)
"""
    with child(tmp_path, body) as mediapipe:
        found = mediapipe.track("yz", RIG, views(7))
    assert (found.wall_ms, found.processor_ms, found.toggles) == (3.0, 2.0, None)
    assert found.points["index"] == pytest.approx(PLACES["index"], abs=1e-6)


def test_a_child_that_ends_is_told(tmp_path):
    with child(tmp_path, "sys.exit(1)") as mediapipe, pytest.raises(UnavailableError, match=r"ended.*child\.log"):
        mediapipe.track("yz", RIG, views())


def test_an_environment_that_cannot_be_made_says_why(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnavailableError, match="file"):
        install(tmp_path / "file" / "mediapipe")


def test_the_words_of_an_installer_that_tell_most():
    text = "WARNING: slow\nERROR: No matching distribution found for mediapipe==0.10.21\n\nhint: nothing\n"
    assert reason(text) == "ERROR: No matching distribution found for mediapipe==0.10.21"
    assert reason("first\nsecond\n") == "second"
    assert reason("") == ""
