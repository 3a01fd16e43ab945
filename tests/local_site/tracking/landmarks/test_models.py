"""The models that watch the cameras: missing ones name the cure, and are looked for again the next time."""

import pytest

from common.errors import NotInstalledError
from local_site.tracking.landmarks import models
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG


@pytest.fixture(autouse=True)
def _nothing_in_memory():
    models._networks.cache_clear()
    yield
    models._networks.cache_clear()


def test_without_the_models_the_cure_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    with pytest.raises(NotInstalledError, match="farhand models install"):
        models.view_hands(PAIR_RIG, True)


def test_models_that_were_installed_later_are_found(monkeypatch, tmp_path):
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    for _ in range(2):
        with pytest.raises(NotInstalledError):
            models.view_hands(PAIR_RIG, True)
    monkeypatch.setattr(models, "read_model", lambda model: model.name.encode())
    monkeypatch.setattr(models, "LandmarkNetwork", lambda content, outputs: (content, outputs))
    assert len(models.view_hands(PAIR_RIG, True)) == len(PAIR_RIG.cameras)
