"""`farhand` and `python -m farhand`: the command line, quiet about Ctrl-C from its first import on."""

import sys
from importlib.util import find_spec
from pathlib import Path

from farhand.exits import FAILED, INTERRUPTED, catch_signals, sentence

HOME = Path(__file__).resolve().parents[1]
OWN_PACKAGES = ("common", "local_site", "remote_site")


def main() -> None:
    """Run the command line; Ctrl-C and SIGTERM before it listens to them end it with a word, and no traceback."""
    try:
        catch_signals()
        if problem := foreign_package():
            _end(problem, FAILED)
        from farhand.cli import main as run  # noqa: PLC0415  # importing it takes long enough to be interrupted

        run()
    except KeyboardInterrupt:
        _end(sentence(sys.argv[1:]), INTERRUPTED)


def foreign_package() -> str | None:
    """Say what is wrong when Python would import another distribution's `common`, `local_site` or `remote_site`."""
    for name in OWN_PACKAGES:
        spec = find_spec(name)
        if spec is None:
            return f"the package {name} is missing beside {HOME / 'farhand'}; install Farhand again"
        found = next(iter(spec.submodule_search_locations or ()), spec.origin)
        if found is None or Path(found).resolve().parent != HOME:
            return (
                f"Python finds {name} at {found}, which is not Farhand's own at {HOME / name}; "
                "uninstall or rename the other one, or install Farhand into an environment of its own"
            )
    return None


def _end(sentence: str, code: int) -> None:
    print(f"farhand: {sentence}", file=sys.stderr)  # noqa: T201  # the command line's own voice
    sys.exit(code)


if __name__ == "__main__":
    main()
