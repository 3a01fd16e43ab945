"""Check that the networks of the tracker `eye` can be run: a probe, and a pure check."""

from common.errors import ModelError
from farhand.doctor.findings import Finding, error, ok
from local_site.tracking.eye.networks import EyeNetworks

CHECK = "networks of the tracker"


def probe_networks() -> str:
    """Say why the networks cannot be run; empty if they can."""
    try:
        EyeNetworks()
    except ModelError as wrong:
        return str(wrong)
    return ""


def check_networks(wrong: str) -> Finding:
    """Judge what the probe has said."""
    return error(CHECK, wrong, "pip install --force-reinstall --no-deps farhand") if wrong else ok(CHECK, "can be run")
