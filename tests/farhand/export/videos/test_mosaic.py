"""A session as a video: the views in a mosaic, with state and time drawn below."""

import av
import numpy as np
import pytest

from farhand.export.videos.mosaic import MosaicPlan, mosaic
from farhand.export.videos.write import export_mp4
from tests.farhand.export.made_session import MadeSession, drawn


def played(path):
    with av.open(str(path)) as video:
        return [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def test_each_view_has_its_cell_and_one_without_a_picture_says_so():
    plan = MosaicPlan(("a", "b", "c", "d"), (160, 120), 3)
    red = np.full((120, 160, 3), (255, 0, 0), np.uint8)
    whole = mosaic(plan, {"d": red, "a": red[::2, ::2]}, ["one", "two", "three"])
    assert whole.shape == (plan.size_px[1], plan.size_px[0], 3)
    assert (whole[60, 80] == (255, 0, 0)).all()
    assert (whole[180, 240] == (255, 0, 0)).all()
    empty = mosaic(plan, {}, [])
    assert whole[0:120, 160:].tolist() == empty[0:120, 160:].tolist()
    assert empty[0:30, 160:].max() > 200  # it says that there is no picture


def test_text_is_drawn_below_and_differs_with_what_it_says():
    plan = MosaicPlan(("a",), (640, 480), 2)
    one, two = (mosaic(plan, {}, [line, "öffne"]) for line in ("episode 1", "episode 2"))
    assert (one[:480] == two[:480]).all()
    assert (one[480:] != two[480:]).any()


@pytest.mark.parametrize("cell", [(161, 119), (160, 120)])
def test_sizes_are_even_as_the_codec_needs(cell):
    width, height = MosaicPlan(("a", "b", "c"), cell, 3).size_px
    assert width % 2 == height % 2 == 0


def test_video_shows_the_views_of_each_instant(tmp_path):
    made, told = MadeSession(seconds=2.0, spans=((0.5, 1.5),)), []
    (path,) = export_mp4([made], tmp_path, 25, lambda: False, lambda *step: told.append(step))
    frames = played(path)
    assert len(frames) == 50
    assert told[-1] == ("made", 50, 50)
    for number in (0, 49):
        cell = frames[number][40:120, :160]
        error = [np.abs(cell.astype(int) - drawn((160, 120), k, 0)[40:]).mean() for k in range(50)]
        assert int(np.argmin(error)) == number
        assert error[number] < 4
    assert (frames[10][125:] != frames[20][125:]).any()
