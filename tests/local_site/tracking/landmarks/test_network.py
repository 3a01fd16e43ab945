"""The landmarks' runtime: its absence names the cure, what it prints stays unsaid, and what it refuses is no crash."""

import sys
from importlib.util import find_spec

import pytest

from common.errors import ModelError, NotInstalledError
from local_site.tracking.landmarks.model_files import PALM_DETECTION, read_model
from local_site.tracking.landmarks.network import CURE, LandmarkNetwork

needs_runtime = pytest.mark.skipif(find_spec("ai_edge_litert") is None, reason=f"no runtime: {CURE}, or make learned")


def test_without_its_runtime_the_cure_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ai_edge_litert.interpreter", None)
    with pytest.raises(NotInstalledError, match=r"pip install 'farhand\[learned\]'"):
        LandmarkNetwork(b"", 1)


@needs_runtime
def test_what_is_no_model_is_refused() -> None:
    with pytest.raises(ModelError, match="cannot read a landmark model"):
        LandmarkNetwork(b"no model", 1)


@needs_runtime
def test_nothing_is_printed_but_what_comes_later(capfd: pytest.CaptureFixture[str]) -> None:
    try:
        content = read_model(PALM_DETECTION)
    except NotInstalledError as missing:
        pytest.skip(str(missing))
    LandmarkNetwork(content, 2)
    assert capfd.readouterr().err == ""
    sys.stderr.write("later\n")
    assert capfd.readouterr().err == "later\n"
