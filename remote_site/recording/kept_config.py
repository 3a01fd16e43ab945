"""The configuration as a recording keeps it: all that the pipeline depends on, and nothing that is secret; and back."""

from typing import Any

import msgspec

from common.config.loading import ConfigMistake, build
from common.config.replaced_keys import GONE_KEYS
from common.errors import RecordingError
from common.process.config import MetricsConfig
from common.recording.config import RecordConfig
from remote_site.config import RemoteConfig
from remote_site.link_config import RemoteLinksConfig
from remote_site.simulation.config import SIMULATED
from remote_site.video.config import CameraConfig

RECORDED = "recorded"  # in the place of a device, or of a URL that may contain a password


def encode_config(config: RemoteConfig) -> bytes:
    """The configuration as JSON, without endpoints, driver options, cameras' sources, and where recordings go."""
    replace = msgspec.structs.replace
    kept = replace(
        config,
        links=RemoteLinksConfig(),
        driver=replace(config.driver, options={}),
        video=replace(config.video, cameras=tuple(_without_source(camera) for camera in config.video.cameras)),
        metrics=MetricsConfig(),
        record=RecordConfig(),
    )
    return msgspec.json.format(msgspec.json.encode(kept))


def decode_config(data: bytes) -> RemoteConfig:
    """The configuration that `encode_config` wrote; RecordingError for one of another release."""
    mistakes: list[ConfigMistake] = []
    try:
        config = build(RemoteConfig, _known(msgspec.json.decode(data, type=dict[str, Any])), (), mistakes)
    except msgspec.DecodeError as error:
        raise RecordingError(f"the recorded configuration cannot be read: {error}") from error
    if config is None:
        wrong = "; ".join(f"{'.'.join(mistake.path) or 'the whole'}: {mistake.text}" for mistake in mistakes)
        raise RecordingError(
            f"the recorded configuration is of another release: {wrong}; use the release that recorded it"
        )
    return config


def _known(recorded: dict[str, Any]) -> dict[str, Any]:
    """The recorded tables without the keys that are gone, in place."""
    for key in GONE_KEYS:
        *tables, leaf = key.split(".")
        table: Any = recorded
        for name in tables:
            table = table.get(name) if isinstance(table, dict) else None
        if isinstance(table, dict):
            table.pop(leaf, None)
    return recorded


def _without_source(camera: CameraConfig) -> CameraConfig:
    return camera if camera.source == SIMULATED else msgspec.structs.replace(camera, source=RECORDED)
