"""What a report says of where its track comes from: enough to make the track again."""

from datetime import UTC, datetime
from pathlib import Path

from common.config.loading import load_config
from farhand.tracking.results.report.origin import origin_rows
from local_site.config import LocalConfig

NOW = datetime(2026, 3, 1, 9, 5, tzinfo=UTC)
SOURCES = [("left", "l.avi"), ("right", "r.avi")]


def rows(*settings: str, fps: float | None = 30.0) -> dict[str, str]:
    site = load_config(LocalConfig, None, settings)
    return dict(origin_rows(Path("rig.json"), SOURCES, site, fps, "1.2.3", NOW))


def test_recordings_rig_rate_tracker_version_and_date_are_named() -> None:
    assert rows("tracking.method=learned") == {
        "camera left": "l.avi",
        "camera right": "r.avi",
        "rig": "rig.json",
        "pictures a second": "30",
        "tracker": "learned",
        "settings": "the defaults",
        "Farhand": "1.2.3",
        "tracked on": "2026-03-01 09:05 UTC",
    }


def test_settings_are_those_that_a_track_uses_and_that_are_not_the_defaults() -> None:
    given = rows("tracking.silhouette.right_arm=false", "gesture.hold_ms=50", "preview.fps=5", "tracking.profile_dir=p")
    assert rows("tracking.method=learned", "tracking.silhouette.right_arm=false")["settings"] == "the defaults"
    assert given["settings"] == "tracking.silhouette.right_arm = false, gesture.hold_ms = 50.0"


def test_live_cameras_have_no_stated_rate() -> None:
    assert rows(fps=None)["pictures a second"] == "as the cameras gave them"
