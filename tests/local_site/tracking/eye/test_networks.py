"""The networks' files: one that is damaged or missing is named, with what cures it."""

from pathlib import Path

import pytest

from common.errors import ModelError
from local_site.tracking.eye import networks
from local_site.tracking.eye.networks import EyeNetworks


@pytest.mark.parametrize("content", [None, b"", b"no network"])
def test_a_file_that_is_missing_or_damaged_is_named_with_a_cure(
    content: bytes | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "models").mkdir()
    if content is not None:
        (tmp_path / "models" / "arm.onnx").write_bytes(content)
    monkeypatch.setattr(networks, "files", lambda _: tmp_path)
    networks._session.cache_clear()
    with pytest.raises(ModelError, match=r"the network arm cannot be read.*install Farhand again"):
        EyeNetworks()
