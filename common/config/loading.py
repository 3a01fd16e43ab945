"""From TOML and --set to a checked struct: all mistakes in one error, each with its line and its cure."""

import codecs
import difflib
import re
import tomllib
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin

import msgspec

from common.config.choices import allowed_values, alternatives
from common.config.places import KeyPath, key_lines, key_told
from common.config.replaced_keys import GONE_KEYS, REPLACED_KEYS
from common.config.type_words import as_written, in_plain_words
from common.errors import ConfigError, ConfigFileError

S = TypeVar("S", bound=msgspec.Struct)

MAX_BYTES = 1_000_000  # a device such as /dev/zero never ends
MOST_DEPTH = 32  # tables and lists within one another
DEEP_KEY = re.compile(rf"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MOST_DEPTH}}}""")
TOML_PLACE = re.compile(r" \(at line (\d+), column \d+\)")
TOML_CURES = {
    "Cannot overwrite a value": "; this key stands twice, remove one",
    "Cannot declare": "; this table stands twice: join both, or write each table of a list in double brackets, [[...]]",
    "Invalid value": '; a word stands in quotes, as "word", a number with a point, as 0.5',
}
CURE_UNREAD = "give the path of a file that is there and may be read"
BESIDE = "beside"  # key of Meta.extra of a path that is seen from the configuration's own folder
OF_A_KEY = re.compile(r"(\w+)(?:: | (?=['\d-]))")  # "key: ...", or "key VALUE ..."


@dataclass(frozen=True, slots=True)
class ConfigMistake:
    """One thing that is wrong, at a key of the configuration; `place` is another key whose line it has, if any."""

    path: KeyPath
    text: str
    place: KeyPath = ()


def load_config(struct: type[S], path: Path | None, settings: Sequence[str] = ()) -> S:
    """Read a TOML file (None for the defaults), apply `key=value` settings over it, and check it all.

    A relative path that is marked `beside` is seen from the folder of `path`, and from nowhere else.
    Raises ConfigError with every mistake of the file and the settings, one per line: source, what is wrong, cure.
    """
    read = read_config(struct, path, settings)
    if read.config is None or read.mistakes:
        raise ConfigError("\n".join(map(read.described, read.mistakes)))
    return read.config


@dataclass(frozen=True, slots=True)
class ReadConfig(Generic[S]):
    """A configuration that was read, None where there are mistakes, and how to say these, with their lines.

    `usable` is the configuration, or what it would be without the keys that have mistakes.
    """

    config: S | None
    usable: S | None
    mistakes: Sequence[ConfigMistake]
    described: Callable[[ConfigMistake], str]


def read_config(
    struct: type[S], path: Path | None, settings: Sequence[str] = (), *, finds_more: bool = False
) -> ReadConfig[S]:
    """Read as `load_config` does, with mistakes instead of an error where the file can be read at all.

    `finds_more` also finds what is wrong where everything else is right: without the keys that have mistakes.
    """
    table = read_tables(path)
    lines = key_lines(_read(path), table) if path is not None else {}
    if path is not None:
        _take_from_beside(struct, table, path.parent)
    set_paths = {apply_setting(table, setting) for setting in settings}
    mistakes: list[ConfigMistake] = []
    usable = config = build(struct, table, (), mistakes)
    if mistakes and finds_more:
        more: list[ConfigMistake] = []
        usable = build(struct, _without([mistake.path for mistake in mistakes], table), (), more)
        wrong = {mistake.path[:length] for mistake in mistakes for length in range(len(mistake.path))}
        mistakes += [mistake for mistake in more if mistake not in mistakes and mistake.path not in wrong]
    return ReadConfig(config, usable, mistakes, lambda mistake: _describe(mistake, path, lines, set_paths))


def _without(paths: Iterable[KeyPath], table: Mapping[str, Any]) -> dict[str, Any]:
    """The tables without these keys; where one is within a list, without the list."""
    rest = {
        key: _without([path[1:] for path in paths if path[:1] == (key,)], value)
        for key, value in table.items()
        if isinstance(value, dict)
    }
    gone = {path[0] for path in paths if len(path) == 1 or (path and not isinstance(table.get(path[0]), dict))}
    return {key: rest.get(key, value) for key, value in table.items() if key not in gone}


def beside(unless: Callable[[str], bool]) -> dict[str, Any]:
    """Meta.extra of a path that is seen from the configuration's own folder, `unless` its value is no path."""
    return {BESIDE: unless}


def read_tables(path: Path | None) -> dict[str, Any]:
    """The tables of a TOML file, unchecked, none without a file; ConfigError when it cannot be read."""
    if path is None:
        return {}
    text = _read(path)
    if DEEP_KEY.search(text):  # the parser keeps each beginning of a key: a file of 200 kB takes 40 GB
        raise ConfigError(_too_deep(path))
    try:
        table = tomllib.loads(text)
    except RecursionError as error:
        raise ConfigError(_too_deep(path)) from error
    except ValueError as error:  # of the parser, and of a whole number with thousands of digits
        raise ConfigError(_not_toml(path, str(error))) from error
    if _is_deep(table):
        raise ConfigError(_too_deep(path))
    return table


def _is_deep(table: dict[str, Any]) -> bool:
    """Return whether tables and lists are nested deeper than in any configuration."""
    level: list[Any] = [table]
    for _ in range(MOST_DEPTH):
        level = [own for one in level for own in _within(one)]
    return bool(level)


def _within(value: Any) -> Iterable[Any]:
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()


def _too_deep(path: Path) -> str:
    return f"{path}: more than {MOST_DEPTH} tables or lists within one another; give a configuration of Farhand"


def _take_from_beside(struct: type[msgspec.Struct], table: dict[str, Any], folder: Path) -> None:
    """Make the marked paths whole, so that they stay the same wherever a process works."""
    for row in msgspec.structs.fields(struct):
        value, notes = table.get(row.encode_name), getattr(row.type, "__metadata__", ())
        marks = [note.extra[BESIDE] for note in notes if note.extra and BESIDE in note.extra]
        if isinstance(value, str) and value and any(not unless(value) for unless in marks):
            table[row.encode_name] = str((folder / value).absolute())
        elif isinstance(value, dict) and isinstance(row.type, type) and issubclass(row.type, msgspec.Struct):
            _take_from_beside(row.type, value, folder)


def _not_toml(path: Path, error: str) -> str:
    """Format the parser's error with its line, and with the cure for the most frequent mistakes."""
    match = TOML_PLACE.search(error)
    where = f"{path}:{match[1]}" if match else f"{path}"
    cure = next((cure for said, cure in TOML_CURES.items() if error.startswith(said)), "")
    return f"{where}: not valid TOML: {TOML_PLACE.sub('', error)}{cure}"


def build(struct: type[S], table: Mapping[str, Any], path: KeyPath, mistakes: list[ConfigMistake]) -> S | None:
    """The struct from a table of builtins, or None after adding every mistake to `mistakes`."""
    fields = {field.encode_name: field for field in msgspec.structs.fields(struct)}
    before = len(mistakes)
    unknown = ((*path, key) for key in table if key not in fields)
    mistakes += [ConfigMistake(own, _unknown(own, list(fields))) for own in unknown]
    values: dict[str, Any] = {}
    for key, field in fields.items():
        if key in table:
            values[field.name] = _value(field.type, table[key], (*path, key), mistakes)
        elif field.required:
            mistakes.append(ConfigMistake((*path, key), "is missing; give it a value"))
    if len(mistakes) > before:
        return None
    try:
        return struct(**values)
    except (ValueError, ConfigError) as error:
        mistakes.append(_between_keys(path, str(error), fields, table))
        return None


def _between_keys(path: KeyPath, said: str, fields: Container[str], table: Mapping[str, Any]) -> ConfigMistake:
    """Build the mistake that a table reports of its keys together, at the key that its sentence begins with, if any."""
    told = (*path, *key_told(said.replace("".join(f"{part}." for part in path), ""), table))
    found = OF_A_KEY.match(said)
    if found is not None and found[1] in fields:
        return ConfigMistake((*path, found[1]), said[found.end() :], () if found[1] in table else told)
    return ConfigMistake(path, said, told)


def _value(expected: Any, value: Any, path: KeyPath, mistakes: list[ConfigMistake]) -> Any:
    bare = get_args(expected)[0] if get_origin(expected) is Annotated else expected
    if (row := _table_of(bare)) is not None:
        if not isinstance(value, dict):
            mistakes.append(ConfigMistake(path, f"must be a table: [{'.'.join(path)}]"))
            return None
        if row is bare:
            return build(row, value, path, mistakes)
        return {name: _value(row, own, (*path, name), mistakes) for name, own in value.items()}
    if isinstance(value, list) and (row := _row_of(bare)) is not None:
        before = len(mistakes)
        value = [_value(row, own, (*path, str(number)), mistakes) for number, own in enumerate(value, start=1)]
        if len(mistakes) > before:
            return None
    try:
        return msgspec.convert(value, expected)
    except msgspec.ValidationError as error:
        given = f"a list of {len(value)}" if isinstance(value, list) and _row_of(bare) else as_written(value)
        mistakes.append(ConfigMistake(path, f"{given} is not allowed: {_cure(expected, value, str(error))}"))
        return None


def _cure(expected: Any, value: Any, error: str) -> str:
    """Say what may stand in the place of a value that `error` refuses."""
    parts, choices = list(alternatives(expected)), list(map(str, allowed_values(expected)))
    if choices and isinstance(value, str) and (near := difflib.get_close_matches(value, choices, n=1)):
        return f"did you mean {near[0]}?"
    if choices and type(value) not in parts and not (isinstance(value, int) and float in parts):
        number = " or give a number" if float in parts else " or give a whole number" if int in parts else ""
        return f"choose {'one of ' if len(choices) > 1 else ''}{', '.join(choices)}{number}"
    described = [note.description for note in getattr(expected, "__metadata__", ()) if note.description]
    return f"give a {described[0]}" if "regex" in error and described else in_plain_words(error, value, *described[:1])


def _table_of(expected: Any) -> type[msgspec.Struct] | None:
    """The struct of a table, or of each table by its name; None for a value."""
    if get_origin(expected) is dict:
        expected = get_args(expected)[1]
    return expected if isinstance(expected, type) and issubclass(expected, msgspec.Struct) else None


def _row_of(expected: Any) -> type[msgspec.Struct] | None:
    """The struct of each table in a list of tables; None for anything else."""
    if get_origin(expected) is not tuple or get_args(expected)[-1] is not Ellipsis:
        return None
    return _table_of(get_args(expected)[0])


def _unknown(path: KeyPath, known: list[str]) -> str:
    if (replacement := REPLACED_KEYS.get(".".join(path))) is not None:
        return replacement.sentence
    if (cure := GONE_KEYS.get(".".join(path))) is not None:
        return cure
    near = difflib.get_close_matches(path[-1], known, n=1)
    if near:
        return f"is not a key here; did you mean {near[0]}?"
    return f"is not a key here; the keys are {', '.join(sorted(known))}"


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise ConfigFileError(f"cannot read {path}: {error.strerror}; {CURE_UNREAD}") from error
    if len(content) > MAX_BYTES:
        raise ConfigError(f"{path}: larger than {MAX_BYTES} bytes; give a TOML file")
    if content.startswith(codecs.BOM_UTF8):
        raise ConfigError(f"{path}:1: begins with a byte order mark; save the file as UTF-8 without one")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{path}:{line}: not UTF-8 text: {error.reason}; save the file as UTF-8") from error


def apply_setting(table: dict[str, Any], setting: str) -> KeyPath:
    """Put a `table.key=value` setting into the tables, and return its key; ConfigError for an invalid setting."""
    key, separator, raw = setting.partition("=")
    path = tuple(part.strip() for part in key.split("."))
    if not separator or not all(path):
        raise ConfigError(f"--set {setting}: write it as table.key=value")
    *parents, leaf = path
    for parent in parents:
        child = table.setdefault(parent, {})
        if not isinstance(child, dict):
            raise ConfigError(f"--set {setting}: {parent} is a value, not a table")
        table = child
    table[leaf] = _parse_value(raw)
    return path


def _parse_value(raw: str) -> Any:
    try:
        return tomllib.loads(f"value = {raw}")["value"]
    except (ValueError, RecursionError):
        return raw


def _describe(mistake: ConfigMistake, path: Path | None, lines: Mapping[KeyPath, int], set_paths: set[KeyPath]) -> str:
    text = ": ".join(filter(None, (".".join(mistake.path), mistake.text)))
    place = mistake.place or mistake.path
    if path is None or place in set_paths:  # the defaults have no mistake: it comes of a setting
        return f"--set {text}"
    line = next((lines[place[:n]] for n in range(len(place), 0, -1) if place[:n] in lines), None)
    return f"{path}:{line}: {text}" if line else f"{path}: {text}"
