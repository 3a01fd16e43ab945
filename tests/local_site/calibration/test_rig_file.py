"""A rig file comes back as it was written, and is refused with what is wrong when it was cut, edited or mixed up."""

import json

import numpy as np
import pytest

from common.errors import CalibrationError
from local_site.calibration.rig_file import load_rig, save_rig
from local_site.calibration.solve import solve_rig
from tests.local_site.calibration.plate_cameras import ANGLES, camera, control


@pytest.fixture(scope="module")
def rig():
    bent = [camera(angle, k1=-0.1) for angle in (*ANGLES, 0.0)]
    return solve_rig(control(bent, noise=0.1), "now")


@pytest.fixture
def refused(rig, tmp_path):
    """The error for the rig's file after a change to its content."""

    def load_changed(change):
        path = tmp_path / "rig.json"
        save_rig(rig, path)
        content = json.loads(path.read_text())
        changed = change(content)
        path.write_text(changed if isinstance(changed, str) else json.dumps(changed))
        with pytest.raises(CalibrationError) as caught:
            load_rig(path)
        assert "make a rig with: farhand calibrate points" in str(caught.value)
        return str(caught.value)

    return load_changed


def with_cameras(order, **changed):
    """A change that takes the cameras of this order, with some fields of the first changed."""

    def change(content):
        cameras = [content["cameras"][k] for k in order]
        return content | {"cameras": [cameras[0] | changed, *cameras[1:]]}

    return change


def turned(rows):
    """A change of the first camera's projection by a matrix (3, 3) of its pixels."""

    def change(content):
        first = content["cameras"][0]
        return with_cameras((0, 1, 2), projection=(np.array(rows) @ first["projection"]).tolist())(content)

    return change


def test_a_rig_comes_back_as_it_was_written(rig, tmp_path):
    save_rig(rig, tmp_path / "rig.json")
    assert load_rig(tmp_path / "rig.json") == rig
    assert list(tmp_path.iterdir()) == [tmp_path / "rig.json"]


@pytest.mark.parametrize(
    "text", ["", "hello", "[]", "{}", '{"cameras": []}', '{"cameras": [{"name": NaN}]}', '{"volume_min": [1e999,0,0]}']
)
def test_what_is_no_rig_is_refused(refused, text):
    assert "not a rig file of this version, or not whole" in refused(lambda _: text)


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.99])
def test_a_rig_file_that_was_cut_is_refused(refused, kept):
    assert "not whole" in refused(lambda content: json.dumps(content)[: int(kept * len(json.dumps(content)))])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: {key: value for key, value in c.items() if key != "created"}, "missing required field `created`"),
        (lambda c: c | {"format": 1}, "unknown field `format`"),
        (lambda c: json.dumps(c).replace(str(c["cameras"][1]["projection"][0][0]), "NaN"), "malformed"),
        (with_cameras((0, 1, 2), reprojection_rms_px=-1.0), "reprojection_rms_px"),
        (with_cameras((0, 1, 2), size_px=[0, 480]), "size_px"),
        (with_cameras((1, 0, 2)), "its cameras are right, left, third, but must be left, right"),
        (with_cameras((0, 0)), "its cameras are left, left, but"),
        (with_cameras((0,)), "its cameras are left, but"),
        (lambda c: c | {"cameras": []}, "its cameras are none, but"),
        (lambda c: c | {"volume_min": c["volume_max"], "volume_max": c["volume_min"]}, "has no size"),
        (turned([[0, 0, 0], [0, 1, 0], [0, 0, 1]]), "left camera: its projection is singular"),
        (turned([[-1, 0, 640], [0, 1, 0], [0, 0, 1]]), "left camera: its projection is mirrored"),
        (turned([[3, 0, 0], [0, 1, 0], [0, 0, 1]]), "left camera: its projection is not that of a camera"),
        (turned([[1, 0.3, 0], [0, 1, 0], [0, 0, 1]]), "left camera: its projection is not that of a camera"),
        (
            with_cameras((0, 1, 2), lens={"fx": 800, "fy": 800, "cx": 320, "cy": 240, "k1": 50}),
            "distorts the picture implausibly",
        ),
    ],
)
def test_a_rig_file_that_was_edited_is_refused_with_what_is_wrong(refused, change, said):
    assert said in refused(change)


def test_projections_of_one_camera_or_of_exchanged_ones_are_refused(refused):
    def projections(order):
        def change(content):
            own = [camera["projection"] for camera in content["cameras"]]
            for camera_of, k in zip(content["cameras"], order, strict=True):
                camera_of["projection"] = own[k]
            return content

        return change

    assert "exchange the two" in refused(projections((1, 0, 2)))
    assert "from one direction" in refused(projections((0, 0, 2)))


def test_a_camera_that_looks_elsewhere_is_refused(refused):
    def moved(content):
        low, high = content["volume_min"], content["volume_max"]
        return content | {"volume_min": [low[0] + 9.0, *low[1:]], "volume_max": [high[0] + 9.0, *high[1:]]}

    assert "middle of the volume" in refused(moved)


def test_a_rig_is_saved_whole_or_not_at_all(rig, tmp_path):
    (tmp_path / "rig.json").mkdir()
    with pytest.raises(CalibrationError, match="choose another path"):
        save_rig(rig, tmp_path / "rig.json")
    with pytest.raises(CalibrationError, match="choose another path"):
        save_rig(rig, tmp_path / "absent" / "rig.json")
    assert [path.name for path in tmp_path.iterdir()] == ["rig.json"]
