"""A cell without any camera starts, is asked for its status, and ends in order, its simulated robot included."""

import pytest

from tests.integration.sites import running_sites
from tests.integration.test_asked_cell import farhand


@pytest.mark.slow
def test_a_site_without_a_camera_lives_and_ends_as_any_other() -> None:
    with running_sites() as sites:
        remote = sites.remote("driver.name=simulated", "video.cameras=[]")
        sites.wait_for_states()
        shown = farhand("status", "--once", "--video", sites.endpoints.video, sites=sites)
        assert shown.returncode == 0, shown.stderr
        rows = dict(line.split(": ", 1) for line in shown.stdout.splitlines())
        assert not any(name.startswith("camera") for name in rows)
        assert rows["pictures"] == "the cell has no camera"
        assert remote.exit_code is None
        remote.end()
        assert remote.exit_code == 0
