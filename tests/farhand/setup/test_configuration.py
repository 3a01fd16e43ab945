"""The configuration that a setup writes is one that the local site loads."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from common.cameras.settings import CameraSettings
from common.config.loading import load_config
from common.errors import ConfigError
from farhand.setup.configuration import configuration, has_sides, offered_methods
from farhand.setup.notes import SetupAnswers, SetupFolder
from local_site.config import LocalConfig
from local_site.tracking.registry import tracker_names

ANSWERS = SetupAnswers(
    left="/dev/v4l/by-path/usb-1",
    right='rtsp://cam"era\\2',
    cameras=CameraSettings(width_px=1280, height_px=720, fps=60.0, pixel_format="MJPG", exposure_ms="auto"),
    method="silhouette",
    right_arm=False,
)


def loaded(answers, folder):
    path = folder / "local.toml"
    path.write_text(configuration(answers, folder / "rig.json", path))
    return load_config(LocalConfig, path)


def test_every_answer_is_in_what_the_site_loads(tmp_path):
    config = loaded(ANSWERS, tmp_path)
    assert config.operator.sources == (ANSWERS.left, ANSWERS.right)
    assert config.operator.rig == str(tmp_path / "rig.json")
    assert config.operator.cameras == ANSWERS.cameras
    assert config.tracking.method == "silhouette"
    assert not config.tracking.silhouette.right_arm
    assert config.tracking.profile_dir == str(tmp_path / "operators")


@pytest.mark.parametrize("method", offered_methods())
def test_every_tracker_that_is_offered_can_be_configured(method, tmp_path):
    answers = SetupAnswers(left="0", right="1", method=method)
    config = loaded(answers, tmp_path)
    assert config.tracking.method == method
    assert config.operator.sources == ("0", "1")


def test_trackers_are_offered_as_the_configuration_knows_them():
    assert set(offered_methods()) == set(tracker_names()) - {"monocular"}
    assert next(iter(offered_methods())) == "silhouette"
    assert has_sides("silhouette")
    assert not has_sides("markers")


def test_an_answer_that_is_missing_is_named(tmp_path):
    with pytest.raises(ConfigError, match="start farhand setup again"):
        configuration(SetupAnswers(left="0"), tmp_path / "rig.json", tmp_path / "local.toml")


def test_answers_are_kept_and_read_again(tmp_path):
    folder = SetupFolder(tmp_path)
    assert folder.answers() == SetupAnswers()
    assert folder.keep(ANSWERS) is ANSWERS
    assert folder.answers() == ANSWERS


def test_damaged_answers_are_refused_with_the_cure(tmp_path):
    (tmp_path / "answers.json").write_text('{"left": 3')
    with pytest.raises(ConfigError, match=r"answers\.json cannot be used.*remove it"):
        SetupFolder(tmp_path).answers()


@given(
    st.text(),
    st.text(st.characters(exclude_characters="/\0", exclude_categories=["Cs"]), min_size=1).filter(
        lambda name: name not in (".", "..")
    ),
)
@example('"\n[links]\nremote = "tcp/evil:1"\n', "x\n[links]\nremote = 'tcp-evil'\n.toml")
def test_no_cameras_address_and_no_files_name_becomes_a_key(source, name):
    path = Path("/sites") / name
    written = tomllib.loads(configuration(replace(ANSWERS, left=source), Path("/rigs") / name, path))
    plain = tomllib.loads(configuration(ANSWERS, Path("/rigs/rig.json"), Path("/sites/local.toml")))
    operator = plain["operator"] | {"left": source, "rig": str((Path("/rigs") / name).resolve())}
    assert written == plain | {"operator": operator}
