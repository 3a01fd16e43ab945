"""`farhand doctor`: checks this machine and a site's configuration."""

from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.options import Settings
from farhand.exit_codes import FAILED


def doctor(
    config: Annotated[
        Path | None, typer.Option("--config", help="TOML file of either site; without one, both sites' defaults.")
    ] = None,
    settings: Settings = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Check this machine and a configuration, and suggest fixes; the exit code is 1 if any finding is an error.

    Example: farhand doctor --config /etc/farhand/local.toml
    """
    from farhand.doctor import findings
    from farhand.doctor.run import examine

    found = examine(config, settings or ())
    typer.echo(findings.as_json(found) if as_json else findings.as_text(found))
    if findings.worst(found) is findings.Severity.ERROR:
        raise typer.Exit(FAILED)
