"""`farhand` and `python -m farhand`: the command line, quiet about Ctrl-C from its first import on."""

import sys

from farhand.exit_codes import INTERRUPTED


def main() -> None:
    """Run the command line; an interruption before it listens to signals ends without a traceback."""
    try:
        from farhand.cli import main as run  # noqa: PLC0415  # importing it takes long enough to be interrupted

        run()
    except KeyboardInterrupt:
        print("farhand: interrupted", file=sys.stderr)  # noqa: T201  # the command line's own voice
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
