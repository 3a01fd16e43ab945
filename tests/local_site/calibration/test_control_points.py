"""Control point files: what is read, and that every mistake is named with its line."""

import pytest

from common.errors import CalibrationError
from local_site.calibration.control_points import HEADER, MAX_NAMED, read_control_points


def write(tmp_path, *lines):
    path = tmp_path / "points.csv"
    path.write_text("\n".join([",".join(HEADER), *lines]))
    return path


def test_points_come_in_metres_and_unseen_pixels_as_nan(tmp_path):
    control = read_control_points(write(tmp_path, "1000,0,500,1.5,2.5,,", "", "0,0,0,,,3,4"))
    assert control.points.tolist() == [[1.0, 0.0, 0.5], [0.0, 0.0, 0.0]]
    assert control.pixels[0][0].tolist() == [1.5, 2.5]
    assert [str(v) for v in control.pixels[1][0]] == ["nan", "nan"]
    assert control.labels == ("line 2", "line 4")
    assert control.cameras == ("left", "right")


def test_a_third_and_a_fourth_camera_bring_columns_of_their_own(tmp_path):
    path = tmp_path / "four.csv"
    path.write_text(
        ",".join([*HEADER, "u3_px", "v3_px", "u4_px", "v4_px"]) + "\n0,0,0,1,2,3,4,5,6,,\n1,1,1,1,2,3,4,,,7,\n"
    )
    with pytest.raises(CalibrationError, match="line 3: only one pixel coordinate for the fourth camera"):
        read_control_points(path)
    path.write_text(",".join([*HEADER, "u3_px", "v3_px"]) + "\n0,0,0,1,2,3,4,5,6\n")
    control = read_control_points(path, size=(640, 480))
    assert control.cameras == ("left", "right", "third")
    assert control.pixels[2].tolist() == [[5.0, 6.0]]
    assert control.sizes == ((640, 480),) * 3


def test_all_mistakes_are_named_at_once(tmp_path):
    path = write(
        tmp_path,
        "0,0,0,1,2,3,4",
        "x,0,0,1,2,3,4",
        "1,0,0,inf,2,3,4",
        "2,,0,1,2,3,4",
        "3,0,0,1,,3,4",
        "4,0",
        "0,0,0,1,2,3,4",
    )
    with pytest.raises(CalibrationError) as caught:
        read_control_points(path)
    text = str(caught.value)
    for expected in (
        "line 3: X_mm is 'x', not a number",
        "line 4: uL_px is inf",
        "line 5: Y_mm is empty",
        "line 6: only one pixel coordinate for the left camera",
        "line 7: 2 columns, not 7",
        "line 8: the same point as line 2",
    ):
        assert expected in text


def test_a_long_list_of_mistakes_is_cut(tmp_path):
    with pytest.raises(CalibrationError, match=r"\.\.\. and 5 more"):
        read_control_points(write(tmp_path, *[f"?,{k},0,1,2,3,4" for k in range(MAX_NAMED + 5)]))


@pytest.mark.parametrize("text", ["", "X,Y,Z\n1,2,3\n", "\x00\n"])
def test_a_wrong_header_is_refused(tmp_path, text):
    path = tmp_path / "points.csv"
    path.write_text(text)
    with pytest.raises(CalibrationError):
        read_control_points(path)


def test_a_file_that_is_missing_or_no_text_is_refused(tmp_path):
    with pytest.raises(CalibrationError, match="No such file or directory; give the path of a CSV file"):
        read_control_points(tmp_path / "absent.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x80" * 10)
    with pytest.raises(CalibrationError, match="is not UTF-8 text; save it as CSV in UTF-8"):
        read_control_points(binary)
