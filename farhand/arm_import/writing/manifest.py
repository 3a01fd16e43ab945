"""Digests by SHA-256 of what an import wrote, in the arm's file: only files that still match are replaced; pure."""

import hashlib
from collections.abc import Mapping

from common.text import in_xml_comment

HEAD = b"<!-- As farhand arm import wrote these files, by SHA-256. It replaces them only while they are still so:\n"


def with_manifest(urdf: bytes, name: str, others: Mapping[str, bytes]) -> bytes:
    """The arm's file `name` with the digests of its own text and of the other files."""
    lines = [f"  {digest(content)}  {in_xml_comment(file)}\n" for file, content in {name: urdf, **others}.items()]
    return urdf + HEAD + "".join(lines).encode() + b"-->\n"


def digests_in(urdf: bytes) -> dict[str, str]:
    """By name the digests that an arm's file ends with; none where no import wrote it."""
    lines = urdf.partition(HEAD)[2].decode(errors="replace").splitlines()
    rows = [line.strip().split("  ", 1) for line in lines]
    return {row[1]: row[0] for row in rows if len(row) > 1}


def is_as_written(name: str, content: bytes, digests: Mapping[str, str]) -> bool:
    """Return whether a file is as it was when these digests were made."""
    return digests.get(in_xml_comment(name)) == digest(content)


def digest(content: bytes) -> str:
    """Of a file, without the digests that an arm's file ends with."""
    return hashlib.sha256(content.partition(HEAD)[0]).hexdigest()
