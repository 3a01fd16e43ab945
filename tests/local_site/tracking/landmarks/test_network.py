"""A network that cannot be run is a ModelError that names the cure, never a traceback of the runtime."""

import sys

import pytest

from common.errors import ModelError
from local_site.tracking.landmarks import models
from local_site.tracking.landmarks.network import Network
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG


@pytest.fixture
def _no_models_in_memory():
    models._networks.cache_clear()
    yield
    models._networks.cache_clear()


def test_without_the_runtime_the_cure_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ai_edge_litert.interpreter", None)
    with pytest.raises(ModelError, match=r"pip install 'farhand\[learned\]'"):
        Network(b"whatever", 2)


@pytest.mark.parametrize("content", [b"", b"no model", b"TFL3" + bytes(64), bytes(4096)])
def test_a_broken_model_is_refused(content):
    pytest.importorskip(
        "ai_edge_litert", reason="the landmark runtime is not installed: pip install 'farhand[learned]'"
    )
    with pytest.raises(ModelError, match="cannot read a landmark model"):
        Network(content, 2)


@pytest.mark.usefixtures("_no_models_in_memory")
def test_without_the_models_the_cure_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    with pytest.raises(ModelError, match="farhand models install"):
        models.view_hands(PAIR_RIG, True)


@pytest.mark.usefixtures("_no_models_in_memory")
def test_models_that_were_installed_later_are_found(monkeypatch, tmp_path):
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    for _ in range(2):
        with pytest.raises(ModelError):
            models.view_hands(PAIR_RIG, True)
    monkeypatch.setattr(models, "read_model", lambda model: model.name.encode())
    monkeypatch.setattr(models, "Network", lambda content, outputs: (content, outputs))
    assert len(models.view_hands(PAIR_RIG, True)) == len(PAIR_RIG.cameras)
