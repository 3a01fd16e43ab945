"""Finds every mistake of a configuration at once: of its keys and values, and what a start would refuse of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common.config.loading import ConfigMistake, read_config, read_tables
from common.config.places import KeyPath, key_told
from common.errors import ConfigError
from farhand.deployment.kinds import KINDS, Configuration, likeliest
from farhand.deployment.mix_ups import COMMANDS
from farhand.deployment.refusals import links_table, refused_links, refused_operator
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig

BUILT_OF = ("robot", "model"), ("robot", "tool_frame"), ("driver", "name")  # without these no arm can be judged
FILMED_BY = "operator", "simulation"  # tables without which the cameras cannot be


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
    wrong = {mistake.path for mistake in read.mistakes}
    mistakes = list(read.mistakes)
    config: Configuration | None = read.usable
    if config is not None and not any(_is_in(key, links_table(config)) for key in wrong):
        mistakes += refused_links(config)
    if isinstance(config, LocalConfig) and not any(_is_in(key, (table,)) for key in wrong for table in FILMED_BY):
        mistakes += refused_operator(config)
    if isinstance(config, RemoteConfig) and not any(own[:n] in wrong for own in BUILT_OF for n in range(3)):
        mistakes += _of_arm(config, read_tables(path))
    return [read.described(mistake) for mistake in mistakes]


def _is_in(key: KeyPath, table: KeyPath) -> bool:
    return key[: len(table)] == table


def _of_arm(config: RemoteConfig, tables: Mapping[str, Any]) -> Iterator[ConfigMistake]:
    """The mistakes of the arm, each with the line of the key that it is about, as far as it is given."""
    from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # loads what an arm is computed with

    for mistake in find_mistakes(config):
        sentence = f"{mistake.sentence}; {mistake.cure}"
        yield ConfigMistake((), sentence, key_told(sentence, tables))
