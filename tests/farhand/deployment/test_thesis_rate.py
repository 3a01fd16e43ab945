"""The thesis's own rate as it is shipped: the doctor finds no mistake, and the arm follows without a hold."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from common.config.loading import load_config
from common.errors import ProcessError
from farhand.deployment.shipped import HERE, configuration_files
from farhand.doctor.examination import examine
from farhand.doctor.findings import Severity, worst
from farhand.loopback.plan import LoopbackOptions, plan_of
from farhand.loopback.site_process import free_ports
from lab.experiments.follow import THESIS_SMOOTHING
from lab.experiments.following import Film, ToolPath, film, follow_by_pipeline
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig

LOCAL, REMOTE = (HERE / "sites" / f"{site}-thesis.toml" for site in ("local", "remote"))
SECONDS, STILL_S = 10.0, 4.0
LATE_MS = 150.0  # from the exposure to the arrival: what is left of 400 ms, less a period and a camera's irregularity


@pytest.fixture(scope="module")
def local() -> LocalConfig:
    return load_config(LocalConfig, LOCAL)


@pytest.fixture(scope="module")
def filmed(local: LocalConfig) -> Film:
    still = msgspec.structs.replace(local.simulation.motion, still_s=STILL_S)
    simulation = msgspec.structs.replace(local.simulation, motion=still)
    return film(simulation, local.tracking, simulation.fps, SECONDS, lambda: None)


def followed(filmed: Film, local: LocalConfig, *settings: str) -> ToolPath:
    return follow_by_pipeline(filmed, local.smoothing, load_config(RemoteConfig, REMOTE, settings), LATE_MS)


def test_one_name_stands_for_the_files_of_both_sites_and_a_file_of_that_name_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert configuration_files(Path("thesis")) == (LOCAL, REMOTE)
    assert configuration_files(Path("thesiss")) == (Path("thesiss"),)
    Path("thesis").write_text("[driver]\n")
    assert configuration_files(Path("thesis")) == (Path("thesis"),)


def test_the_loopback_runs_both_at_the_rate_of_the_thesis() -> None:
    plan = plan_of(LoopbackOptions(configs=(LOCAL, REMOTE), tracker="silhouette"))
    local, remote = plan.local.load(), plan.remote.load()
    assert (local.operator.fps, local.simulation.fps, local.smoothing) == (5.0, 5.0, THESIS_SMOOTHING)
    assert remote.safety.t_soft_ms == 400.0


@pytest.mark.slow
@pytest.mark.parametrize("path", [LOCAL, REMOTE])
def test_the_doctor_finds_no_mistake_in_it(path: Path) -> None:
    ports = [f"tcp/127.0.0.1:{port}" for port in free_ports(2)]
    names = ("control", "video") if path == REMOTE else ("remote", "listen")
    settings = [f"links.{name}={port}" for name, port in zip(names, ports, strict=True)]
    findings = [finding for finding in examine(path, settings) if finding.check not in {"rendering", "shared memory"}]
    assert worst(findings) is not Severity.ERROR, findings


@pytest.mark.slow
def test_the_arm_follows_without_a_hold_as_fast_as_the_age_limit_allows(filmed: Film, local: LocalConfig) -> None:
    path = followed(filmed, local)
    assert path.hindered == {}
    moved_mm = 1e3 * np.linalg.norm(path.poses[-1][:3, 3] - path.poses[0][:3, 3])
    assert moved_mm > 50.0


def test_with_the_limit_of_faster_cameras_it_is_refused(filmed: Film, local: LocalConfig) -> None:
    with pytest.raises(ProcessError, match="never engaged"):
        followed(filmed, local, "safety.t_soft_ms=150")
