"""Finds every mistake of a configuration at once: of its keys and values, and of the arm that they describe."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common.config.loading import ConfigMistake, ReadConfig, read_config, read_tables
from common.errors import ConfigError
from farhand.deployment.kinds import KINDS, Configuration, likeliest
from farhand.deployment.mix_ups import COMMANDS
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig

KEY = re.compile(r"[a-z_]+(\.[a-z_]+)+")
BUILT_OF = ("robot", "model"), ("robot", "tool_frame"), ("driver", "name")  # without these no arm can be judged


@dataclass(frozen=True, slots=True)
class CheckedFile:
    """A file, the command that it is for (empty where that cannot be known), and what is wrong with it."""

    file: Path
    command: str
    mistakes: list[str]

    def in_words(self) -> list[str]:
        """A line for each mistake, or one that there is none."""
        if not self.command and not self.mistakes:
            return [f"{self.file}: empty, so that every default counts; to begin one: farhand config show remote"]
        return self.mistakes or [f"{self.file}: no mistake; for this file: farhand {self.command} --config {self.file}"]


def check_file(path: Path) -> CheckedFile:
    """Every mistake of a file."""
    try:
        if not read_tables(path):
            return CheckedFile(path, "", [])
        kind = _kind_of(path)
        return CheckedFile(path, COMMANDS[kind], _mistakes(kind, path))
    except ConfigError as error:
        return CheckedFile(path, "", str(error).splitlines())


def _kind_of(path: Path) -> type[Configuration]:
    kinds = likeliest(read_tables(path), tuple(KINDS))
    sites = [kind for kind in kinds if kind in (RemoteConfig, LocalConfig)]
    return (sites or kinds)[0]


def _mistakes(kind: type[Configuration], path: Path) -> list[str]:
    read = read_config(kind, path, finds_more=True)
    mistakes = [read.described(mistake) for mistake in read.mistakes]
    wrong = {mistake.path for mistake in read.mistakes}
    if isinstance(read.usable, RemoteConfig) and not any(own[:n] in wrong for own in BUILT_OF for n in range(3)):
        from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # loads what an arm is computed with

        mistakes += (_of_arm(path, read, f"{each.sentence}; {each.cure}") for each in find_mistakes(read.usable))
    return mistakes


def _of_arm(path: Path, read: ReadConfig[Any], sentence: str) -> str:
    """A mistake of the arm, with the line of the key that the sentence begins with, if it does."""
    key, _, rest = sentence.partition(" ")
    return read.described(ConfigMistake(tuple(key.split(".")), rest)) if KEY.fullmatch(key) else f"{path}: {sentence}"
