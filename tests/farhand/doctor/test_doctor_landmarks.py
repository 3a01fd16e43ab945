"""The doctor and the models of the tracker `learned`: missing, changed, in the service's folder, or not needed."""

from pathlib import Path

import pytest

from farhand.doctor import landmarks
from farhand.doctor.examination import examine_local
from farhand.doctor.findings import Severity
from farhand.doctor.landmarks import check_landmarks, probe_landmarks
from farhand.doctor.machine import check_networks
from local_site.config import LocalConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.landmarks.model_files import FOLDER, MODEL_FILES


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's cache folder on a host without the service."""
    monkeypatch.delenv("CACHE_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(landmarks, "SERVICE_CACHE", tmp_path / "service")
    return tmp_path / "cache"


def test_models_that_are_missing_or_changed_are_named_with_the_cure(cache: Path) -> None:
    folder = cache / FOLDER
    folder.mkdir(parents=True)
    (folder / MODEL_FILES[0].name).write_bytes(b"changed")
    facts = probe_landmarks()
    assert facts.wrong == tuple(model.name for model in MODEL_FILES)
    finding = check_landmarks(facts)[1]
    assert (finding.level, finding.cure) == ("error", "farhand models install")
    assert str(folder) in finding.sentence


def test_where_the_service_is_installed_its_own_folder_counts(cache: Path) -> None:
    service = cache.parent / "service"
    service.mkdir()
    facts = probe_landmarks()
    assert facts.folder == str(service / "models")
    assert facts.cure == f"sudo -u farhand env CACHE_DIRECTORY={service} farhand models install"


@pytest.mark.slow
def test_only_the_tracker_that_uses_them_is_asked_for_them(cache: Path) -> None:
    assert not cache.exists()
    checks = {
        method: {finding.check for finding in examine_local(LocalConfig(tracking=TrackingConfig(method=method)))}
        for method in ("silhouette", "learned", "eye")
    }
    assert checks["learned"] - checks["silhouette"] == {"runtime of the landmarks", "landmark models"}
    assert checks["eye"] - checks["silhouette"] == {"networks of the tracker"}


def test_networks_that_cannot_be_run_are_an_error_with_its_cure() -> None:
    assert check_networks("").level is Severity.OK
    wrong = check_networks("the network arm cannot be read")
    assert wrong.level is Severity.ERROR
    assert "reinstall" in wrong.cure
