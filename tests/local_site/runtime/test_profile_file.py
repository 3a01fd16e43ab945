"""An operator's profile: saved and found again, refused with the cure, and no other operator's touched."""

import msgspec
import numpy as np
import pytest

from common.errors import ConfigError
from local_site.runtime.profile_file import (
    SAVE_EVERY_NS,
    ProfileStore,
    load_profile,
    save_profile,
)
from local_site.tracking.silhouette.hand_model.habits import Habits
from local_site.tracking.silhouette.operator_profile import MOST_PAIRS, make_profile

PROFILE = make_profile(0.93, Habits().own, 0.262, 10)
LATER = make_profile(0.94, Habits().own, 0.265, 20)


def refusing(sentence):
    raise AssertionError(sentence)


def test_what_is_saved_is_found_again(tmp_path):
    path = tmp_path / "state/anna.json"
    assert load_profile(path) is None
    save_profile(PROFILE, path)
    found = load_profile(path)
    assert found == PROFILE
    np.testing.assert_array_equal(found.habits.information, Habits().own.information)
    assert [p.name for p in path.parent.iterdir()] == ["anna.json"]


@pytest.mark.parametrize(
    "change",
    [
        {"scale": 9.0},
        {"posture": [0.0] * 9},
        {"posture": [4.0] + [0.0] * 9},
        {"information": [[0.0] * 10] * 10},
        {"information": [[float(k < j) for k in range(10)] for j in range(10)]},
        {"forearm_length_m": -0.2},
        {"pairs": MOST_PAIRS + 1},
        {"surname": "unknown"},
    ],
)
def test_what_is_no_profile_is_refused_with_the_cure(change, tmp_path):
    path = tmp_path / "anna.json"
    path.write_bytes(msgspec.json.encode(msgspec.to_builtins(PROFILE) | change))
    with pytest.raises(ConfigError, match=r"anna\.json.*delete it"):
        load_profile(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b'{"scale": 0.9'])
def test_half_a_file_is_refused_with_the_cure(content, tmp_path):
    path = tmp_path / "anna.json"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="delete it"):
        load_profile(path)


def test_each_operator_has_a_profile_of_their_own(tmp_path):
    save_profile(PROFILE, tmp_path / "anna.json")
    before = (tmp_path / "anna.json").read_bytes()
    keeper = ProfileStore(str(tmp_path), "berta", refusing)
    assert keeper.known is None
    keeper.save(lambda: LATER)
    assert (tmp_path / "anna.json").read_bytes() == before
    assert ProfileStore(str(tmp_path), "berta", refusing).known == LATER


def test_it_is_saved_every_minute(tmp_path):
    keeper, path = ProfileStore(str(tmp_path), "anna", refusing), tmp_path / "anna.json"
    for t_ns in (5, SAVE_EVERY_NS):
        keeper.keep(lambda: PROFILE, t_ns)
        assert not path.exists()
    keeper.keep(lambda: None, SAVE_EVERY_NS + 5)
    assert not path.exists()
    keeper.keep(lambda: LATER, 2 * SAVE_EVERY_NS + 5)
    assert load_profile(path) == LATER


def test_a_damaged_profile_is_told_once_and_left_as_it_is(tmp_path):
    path, told = tmp_path / "anna.json", list[str]()
    path.write_bytes(b"{")
    keeper = ProfileStore(str(tmp_path), "anna", told.append)
    keeper.save(lambda: PROFILE)
    assert keeper.known is None
    assert path.read_bytes() == b"{"
    assert len(told) == 1


def test_a_folder_that_cannot_be_written_is_told_once(tmp_path):
    told: list[str] = []
    keeper = ProfileStore(str(tmp_path / "folder"), "anna", told.append)
    (tmp_path / "folder").write_bytes(b"")
    keeper.save(lambda: PROFILE)
    keeper.save(lambda: PROFILE)
    assert len(told) == 1
    assert "profile_dir" in told[0]


def test_without_a_folder_nothing_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ProfileStore("", "anna", refusing).save(lambda: PROFILE)
    assert not list(tmp_path.iterdir())
