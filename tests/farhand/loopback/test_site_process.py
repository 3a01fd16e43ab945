"""A process under the loopback: its last error, its events, and its end."""

import sys
from pathlib import Path

import pytest

from farhand.loopback import site_process
from farhand.loopback.site_process import SiteProcess
from lab.stage.waiting import until

SAYING = "import sys; print({text!r}, file=sys.stderr); sys.exit(3)"
STUBBORN = """
import signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
print('deaf', file=sys.stderr, flush=True)
time.sleep(60)
"""


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("level=info event=a\nfarhand: first mistake\nsecond mistake", "first mistake\nsecond mistake"),
        ("farhand: earlier\nlevel=error event=b\nfarhand: the reason", "the reason"),
        ("level=error event=b\nTraceback", "level=error event=b"),
        ("Segmentation fault", "Segmentation fault"),
    ],
)
def test_an_ended_process_gives_its_reason(text: str, error: str) -> None:
    process = SiteProcess("test", [sys.executable, "-c", SAYING.format(text=text)], {})
    until(lambda: process.exit_code is not None)
    assert process.exit_code == 3
    assert process.last_error() == error


def test_a_silent_process_is_reported_as_such() -> None:
    process = SiteProcess("test", [sys.executable, "-c", ""], {})
    until(lambda: process.exit_code is not None)
    assert process.last_error() == "it printed nothing"


def test_only_what_is_more_than_information_is_an_event() -> None:
    text = "level=info event=a\nlevel=warning event=b"
    process = SiteProcess("test", [sys.executable, "-c", SAYING.format(text=text)], {})
    until(lambda: process.exit_code is not None)
    process.end()
    assert [*process.lines] == text.splitlines()
    assert [*process.events] == ["test: level=warning event=b"]


def test_a_process_that_does_not_end_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(site_process, "END_TIMEOUT_S", 0.2)
    process = SiteProcess("test", [sys.executable, "-c", STUBBORN], {})
    until(lambda: "deaf" in process.lines)
    process.end()
    assert process.exit_code == -9
    assert process.events[-1] == "test had to be killed"


def test_a_site_is_of_this_installation_whatever_the_working_folder_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "farhand").mkdir()
    (tmp_path / "farhand/__init__.py").write_text("raise SystemExit(7)")
    monkeypatch.setenv("PYTHONPATH", str(Path(site_process.__file__).parents[2]))
    monkeypatch.chdir(tmp_path)
    process = site_process.start_site("--help", [], tmp_path)
    until(lambda: process.exit_code is not None)
    assert process.exit_code == 0
