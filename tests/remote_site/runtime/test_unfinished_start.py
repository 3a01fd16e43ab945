"""A start that fails half way leaves its marker, so that the next one engages nothing by itself."""

import pytest

from common.errors import ProcessError
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.runtime import app
from remote_site.runtime.crash_marker import CrashMarker
from remote_site.runtime.site_memory import SiteMemory
from remote_site.session.config import EngagementMode


class DyingChildren:
    """Processes that start, and one of which dies before all are ready."""

    def __init__(self, _site: str) -> None:
        self.configs: list[RemoteConfig] = []

    def start(self, _name, main, *, vital=True):  # noqa: ARG002  # as the true one
        """Note the configuration that a process is given."""
        self.configs += [part for part in main.args if isinstance(part, RemoteConfig)]

    def wait_ready(self, _timeout_s, _should_stop):
        """The video process dies."""
        raise ProcessError("remote: process video died")

    def end(self):
        """Nothing to end."""


@pytest.fixture
def started(monkeypatch, tmp_path):
    """Starts the remote site with a video process that dies; the modes of engagement that its processes were given."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    sites: list[DyingChildren] = []
    memories: list[SiteMemory] = []

    def children(name):
        sites.append(DyingChildren(name))
        return sites[-1]

    def memory():
        memories.append(SiteMemory())
        return memories[-1]

    monkeypatch.setattr(app, "Children", children)
    monkeypatch.setattr(app, "SiteMemory", memory)
    monkeypatch.setattr(app, "_check_start", lambda _config: None)

    def start():
        config = RemoteConfig().engaging(EngagementMode.AUTOMATIC)
        with pytest.raises(ProcessError):
            app.run_remote(config, StopFlag())
        assert not memories[-1].ready
        return {given.engagement.mode for given in sites[-1].configs}

    return start


def test_the_next_start_engages_nothing_by_itself(started):
    assert started() == {EngagementMode.AUTOMATIC}
    assert started() == {EngagementMode.ON_REQUEST}
    assert CrashMarker(RemoteConfig().cell).set()
