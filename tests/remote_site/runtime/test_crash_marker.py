"""The crash marker in a folder that others can write to: no link of theirs leads it anywhere."""

import os

import pytest

from common.errors import ConfigError
from remote_site.runtime.crash_marker import CrashMarker


@pytest.fixture
def shared(tmp_path, monkeypatch):
    """The folder of the markers of a cell, below a state folder that others share."""
    state = tmp_path / "state"
    state.mkdir()
    monkeypatch.setenv("STATE_DIRECTORY", str(state))
    return state / "unfinished" / "cell"


@pytest.mark.parametrize("exists", [True, False])
def test_a_link_in_the_place_of_the_own_marker_is_refused_and_not_followed(shared, tmp_path, exists):
    target = tmp_path / "target"
    if exists:
        target.write_text("of somebody else")
    shared.mkdir(parents=True)
    (shared / str(os.getpid())).symlink_to(target)
    with pytest.raises(ConfigError, match=rf"{os.getpid()} is a symbolic link.*STATE_DIRECTORY"):
        CrashMarker("cell").set()
    assert target.exists() == exists


def test_a_link_in_the_place_of_another_marker_counts_as_one_that_is_left_and_is_not_followed(shared, tmp_path):
    target = tmp_path / "target"
    os.mkfifo(target)  # to open it would take for ever
    shared.mkdir(parents=True)
    (shared / "999").symlink_to(target)
    (shared / "998").symlink_to(tmp_path / "nothing")
    marker = CrashMarker("cell")
    assert marker.set()
    marker.clear()
    assert target.exists()
    assert list(shared.iterdir()) == []


@pytest.mark.parametrize("depth", [0, 1])
def test_a_link_in_the_place_of_a_folder_is_refused_and_nothing_made_where_it_leads(shared, tmp_path, depth):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    link = (shared.parent, shared)[depth]
    link.parent.mkdir(exist_ok=True)
    link.symlink_to(elsewhere)
    with pytest.raises(ConfigError, match=f"{link} is a symbolic link"):
        CrashMarker("cell").set()
    assert list(elsewhere.iterdir()) == []


def test_a_folder_of_another_user_who_could_take_the_marker_away_is_refused(shared, monkeypatch):
    shared.mkdir(parents=True)
    monkeypatch.setattr(os, "geteuid", lambda: shared.stat().st_uid + 1)
    with pytest.raises(ConfigError, match=f"{shared.parent} belongs to another user"):
        CrashMarker("cell").set()


def test_the_folder_is_for_its_user_alone(shared):
    CrashMarker("cell").set()
    assert [folder.stat().st_mode & 0o777 for folder in (shared.parent, shared)] == [0o700, 0o700]
