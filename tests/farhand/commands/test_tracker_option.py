"""The --tracker option: which tracker runs, and what the simulated operator wears for it."""

import re

import pytest
from typer.testing import CliRunner

from common.config.loading import load_config
from common.errors import ConfigError
from farhand.cli import app
from farhand.loopback.plan import LoopbackOptions, plan_of
from farhand.tracking.summary import Summary
from local_site.config import LocalConfig
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import filming_rig, make_operator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from remote_site.runtime.checks import check_robot
from remote_site.teleop.config import MappingConfig


@pytest.mark.parametrize(("name", "kind"), [("silhouette", SilhouetteTracker), ("markers", MarkerTracker)])
def test_the_loopback_runs_the_tracker_that_is_asked_for_before_an_operator_dressed_for_it(name, kind):
    local = plan_of(LoopbackOptions(tracker=name)).local.load()
    assert isinstance(make_tracker(calibrate_simulated(SimulationConfig()), local.tracking), kind)
    assert local.simulation.markers == (name == "markers")


def test_the_tracker_for_ordinary_rooms_gets_an_operator_in_colour_who_comes_into_an_empty_office():
    room = plan_of(LoopbackOptions(tracker="learned")).local.load().simulation.room
    assert room.scene == "office"
    assert room.empty_s > 2.0, "shorter than the second in which the tracker learns the room"
    settings = ("simulation.room.scene=office", "simulation.room.empty_s=5", "simulation.room.skin=dark")
    chosen = plan_of(LoopbackOptions(tracker="learned", settings=settings)).local.load().simulation.room
    assert (chosen.empty_s, chosen.skin) == (5.0, "dark")
    with pytest.raises(ConfigError, match=r"simulation\.room\.scene"):
        plan_of(LoopbackOptions(tracker="learned", settings=("simulation.room.scene=dark",)))


def test_an_unknown_tracker_is_refused_before_anything_starts():
    with pytest.raises(ConfigError, match=r"tracking\.method"):
        plan_of(LoopbackOptions(tracker="ultrasound"))


def test_each_tracker_has_a_table_of_its_own():
    settings = ("method=markers", "markers.initial_pairs=3", "silhouette.initial_pairs=20")
    config = load_config(TrackingConfig, None, settings)
    assert (config.markers.initial_pairs, config.silhouette.initial_pairs) == (3, 20)


def tracked_with(monkeypatch, *arguments):
    """The local site's configuration that a track command comes to."""
    return told_with(monkeypatch, *arguments)[0]


def told_with(monkeypatch, *arguments):
    """The same, and the warnings."""
    seen = []
    monkeypatch.setattr(
        "farhand.tracking.track_run.run_track", lambda sources, *_: seen.append(sources.site) or Summary()
    )
    result = CliRunner().invoke(app, ["track", "--rig", "r", "--left", "a", "--right", "b", *map(str, arguments)])
    if isinstance(result.exception, ConfigError):
        raise result.exception
    assert result.exit_code == 0, result.output
    return seen[0], result.stderr


def test_a_track_takes_its_parameters_from_the_local_sites_file_and_from_settings(monkeypatch, tmp_path):
    file = tmp_path / "local.toml"
    file.write_text("[tracking.silhouette]\nright_arm = false\n[gesture]\nhold_ms = 50.0\n")
    site = tracked_with(monkeypatch, "--config", file, "--set", "tracking.silhouette.initial_pairs=20")
    assert (site.tracking.silhouette.right_arm, site.tracking.silhouette.initial_pairs) == (False, 20)
    assert site.gesture.hold_ms == 50.0
    assert tracked_with(monkeypatch).tracking.method == "silhouette"
    assert tracked_with(monkeypatch, "--tracker", "markers").tracking.method == "markers"


@pytest.mark.parametrize(
    ("setting", "cure"),
    [
        ("tracking.method=foo", "choose one of: eye, learned, markers"),
        ("tracking.metod=markers", "did you mean method?"),
        ("tracking.silhouette.right_arm=left", "give true or false"),
    ],
)
def test_misuse_of_a_setting_names_the_cure(monkeypatch, setting, cure):
    with pytest.raises(ConfigError, match=re.escape(cure)):
        tracked_with(monkeypatch, "--set", setting)


@pytest.mark.parametrize(
    ("method", "cure"),
    [("bogus", "'bogus' is not allowed: choose one of: eye, learned"), ("markers", "asks for the tracker learned")],
)
def test_no_setting_names_another_tracker_than_the_option(monkeypatch, method, cure):
    with pytest.raises(ConfigError, match=re.escape(cure)):
        tracked_with(monkeypatch, "--tracker", "learned", "--set", f"tracking.method={method}")
    assert tracked_with(monkeypatch, "--tracker", "learned", "--set", "tracking.method=learned")


def test_a_setting_of_another_tracker_is_named_with_the_key_of_the_one_in_use(monkeypatch):
    _, told = told_with(monkeypatch, "--tracker", "learned", "--set", "tracking.silhouette.right_arm=false")
    assert told == (
        "warning: tracking.silhouette.right_arm belongs to the tracker silhouette, but learned is in use: "
        "give tracking.learned.right_arm\n"
    )
    _, told = told_with(monkeypatch, "--set", "tracking.markers.open_ratio=1.2")
    assert told.endswith("but silhouette is in use: leave it out\n")


def test_a_file_may_hold_the_tables_of_all_trackers_and_settings_of_the_one_in_use_are_taken(monkeypatch, tmp_path):
    file = tmp_path / "local.toml"
    file.write_text("[tracking.silhouette]\nright_arm = false\n")
    settings = ("--tracker", "learned", "--set", "tracking.learned.right_arm=false")
    assert told_with(monkeypatch, "--config", file, *settings)[1] == ""


def test_a_folder_of_profiles_is_said_not_to_be_used_by_a_track(monkeypatch):
    _, told = told_with(monkeypatch, "--set", "tracking.profile_dir=profiles")
    assert told.startswith("warning: tracking.profile_dir is not used here")


@pytest.mark.parametrize("command", [["track", "--rig", "r", "--left", "a", "--right", "b"], ["loopback"]])
def test_an_unknown_tracker_is_refused_with_those_there_are(command):
    result = CliRunner().invoke(app, [*command, "--tracker", "foo"])
    assert result.exit_code == 2
    assert all(word in result.output for word in ("--tracker", "silhouette", "markers"))


def test_a_single_camera_takes_no_other_tracker():
    command = ["track", "--rig", "r", "--monocular", "a", "--tracker", "learned"]
    with pytest.raises(ConfigError, match="leave out --tracker"):
        CliRunner().invoke(app, command, catch_exceptions=False, standalone_mode=False)


@pytest.mark.parametrize("arm", ["a465", "humanoid"])
def test_one_camera_sees_a_textured_arm_whose_palm_either_arm_copies(arm):
    plan = plan_of(LoopbackOptions(tracker="monocular", arm=arm))
    local, remote = plan.local.load(), plan.remote.load()
    assert isinstance(make_tracker(filming_rig(local.simulation), local.tracking), MonocularTracker)
    assert local.tracking.monocular.start.by == "silhouette"
    assert (remote.robot.model, remote.mapping.point) == (arm, "palm")
    check_robot(remote)
    points = make_operator(local.simulation).points(0.0)
    assert set(points) == {"elbow", "wrist", "palm"}


def test_the_humanoid_copies_the_wrist_of_an_operator_before_two_cameras():
    plan = plan_of(LoopbackOptions(arm="humanoid"))
    remote = plan.remote.load()
    assert (remote.mapping.point, remote.mapping.base_R_operator) == ("wrist", MappingConfig().base_R_operator)


@pytest.mark.parametrize(
    ("options", "cure"),
    [
        (LoopbackOptions(arm="tentacle"), "choose one of: a465, humanoid"),
        (LoopbackOptions(tracker="monocular", motion="toggles"), "leave --motion out"),
        (LoopbackOptions(arm="humanoid", driver="c500c"), "use simulated or kinematic"),
    ],
)
def test_who_cannot_take_part_is_refused_before_anything_starts(options, cure):
    with pytest.raises(ConfigError, match=re.escape(cure)):
        plan_of(options)


@pytest.mark.parametrize(
    ("settings", "cure"),
    [
        (("simulation.textured=true",), 'needs tracking.method = "monocular"'),
        (("operator.alone=true", "tracking.method=monocular"), "alone are for real cameras"),
        (("operator.alone=true", "operator.left=0", "operator.rig=r"), 'needs tracking.method = "monocular"'),
    ],
)
def test_one_camera_needs_the_tracker_for_it(settings, cure):
    with pytest.raises(ConfigError, match=re.escape(cure)):
        load_config(LocalConfig, None, settings)


def test_one_real_camera_is_enough():
    settings = ("operator.alone=true", "operator.left=0", "operator.rig=r", "tracking.method=monocular")
    assert load_config(LocalConfig, None, settings).operator.sources == (0,)
