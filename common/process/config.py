"""The parameters of the metrics."""

from typing import Annotated

import msgspec
from msgspec import Meta


class MetricsConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The endpoint where Prometheus scrapes this site: on its own host only."""

    port: Annotated[int, Meta(ge=0, le=65535, description="on 127.0.0.1; 0 serves no figures")] = 0

    @property
    def endpoint(self) -> str:
        """The address in the notation of endpoints."""
        return f"tcp/127.0.0.1:{self.port}"
