"""Check that runtime and models of the tracker `learned` are installed and unchanged: a probe, and a pure check."""

import importlib.metadata
from dataclasses import dataclass
from pathlib import Path

from common.errors import NotInstalledError
from farhand.doctor.findings import Finding, error, ok
from local_site.tracking.landmarks.model_files import (
    MODEL_FILES,
    how_to_install,
    model_folder,
    read_model,
    service_cache,
)
from local_site.tracking.landmarks.network import CURE, RUNTIME

SERVICE_CACHE = Path("/var/cache/farhand")


@dataclass(frozen=True, slots=True)
class LandmarkFacts:
    """The runtime's version, empty without it; the models' folder, those missing or changed, and what installs them."""

    runtime: str
    folder: str
    wrong: tuple[str, ...]
    cure: str


def probe_landmarks() -> LandmarkFacts:
    """Look where the installed service will look, where there is one, else in this user's cache folder."""
    service = service_cache() or (str(SERVICE_CACHE) if SERVICE_CACHE.is_dir() else "")
    folder = model_folder(service)
    wrong = []
    for model in MODEL_FILES:
        try:
            read_model(model, folder)
        except NotInstalledError:
            wrong.append(model.name)
    return LandmarkFacts(_runtime(), str(folder), tuple(wrong), how_to_install(service))


def _runtime() -> str:
    try:
        return importlib.metadata.version(RUNTIME)
    except importlib.metadata.PackageNotFoundError:
        return ""


def check_landmarks(facts: LandmarkFacts) -> list[Finding]:
    """The runtime is installed, and every model has the checksum of the one that was tried."""
    return [
        ok("runtime of the landmarks", f"{RUNTIME} {facts.runtime}")
        if facts.runtime
        else error("runtime of the landmarks", f"{RUNTIME} is not installed", CURE),
        error("landmark models", f"missing or changed in {facts.folder}: {', '.join(facts.wrong)}", facts.cure)
        if facts.wrong
        else ok("landmark models", f"all in {facts.folder}, unchanged"),
    ]
