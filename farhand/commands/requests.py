"""Requests to running sites: `farhand engage`, `disengage`, `reset`, `stop`, those of `lease` and `maintenance`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from farhand.commands.options import AsJson, CellName, LinksFile, LocalEndpoint, RemoteEndpoint, console_config
from farhand.terminal import aside, tell, tell_done

if TYPE_CHECKING:
    from common.messages.requests import OperatorAction
    from common.messages.robot import Asker
    from local_site.console.config import ConsoleConfig

OperatorName = Annotated[str, typer.Option("--operator", help="The operator's name, where it is not this host's.")]

lease_app = typer.Typer(
    help="Show who may operate a cell; take the lease, hand it over, release it.\n\nExample: farhand lease show",
    no_args_is_help=True,
)
maintenance_app = typer.Typer(
    help="Stop and reset the arm, without holding the lease.\n\nExample: farhand maintenance reset",
    no_args_is_help=True,
)


def engage(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: OperatorName = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Let the arm follow the hand; after a stop or a fault 'farhand reset' comes first.

    Example: farhand engage --cell cell
    """
    from farhand.authority.engage import request_engage

    links = console_config(config, cell=cell, control=at)
    tell_done(request_engage(links.cell, links.links.control, operator or links.name, links.links), as_json=as_json)


def disengage(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: OperatorName = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """End the engagement, as the lease's holder: the arm comes to rest, and follows again once it is engaged.

    Example: farhand disengage --cell cell
    """
    from farhand.authority.engage import request_disengage

    links = console_config(config, cell=cell, control=at)
    tell_done(request_disengage(links.cell, links.links.control, operator or links.name, links.links), as_json=as_json)


def reset_arm(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: OperatorName = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Clear a stop or a fault, as the lease's holder, and wake a robot that has stopped; nothing moves until 'engage'.

    It says what it clears, such as who has stopped the arm, and clears nothing that came after that.

    Example: farhand reset --cell cell
    """
    from farhand.authority.engage import request_reset

    links = console_config(config, cell=cell, control=at)
    tell_beforehand = aside(as_json=as_json)
    who = operator or links.name
    done = request_reset(links.cell, links.links.control, who, tell_beforehand, links.links)
    tell_done(done, as_json=as_json)


def stop_arm(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: OperatorName = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Stop the arm, with or without the lease, and refuse every engagement until it is reset; power stays on.

    It is asked again for three seconds, until it is acknowledged; if that fails the exit code is 1: use the emergency
    stop, which this never is.

    Example: farhand stop --cell cell
    """
    from farhand.authority.engage import or_unacknowledged, request_stop

    with or_unacknowledged():
        links = console_config(config, cell=cell, control=at)
    tell_done(request_stop(links.cell, links.links.control, operator or links.name, links.links), as_json=as_json)


@lease_app.command("show")
def show(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None, as_json: AsJson = False) -> None:
    """Show who holds the lease of a cell, who asks for it, and what is still missing to engage.

    Example: farhand lease show --cell cell
    """
    from farhand.authority.lease import describe_lease, lease_builtins, seen_state

    links = console_config(config, cell=cell, control=at)
    state = seen_state(links.cell, links.links.control, links.links)
    tell(describe_lease(state), lease_builtins(state), as_json=as_json)


@lease_app.command("take")
def take(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None, as_json: AsJson = False) -> None:
    """Ask for the lease; while another operator holds it, wait for a minute for consent.

    Example: farhand lease take
    """
    from farhand.authority.lease import take_lease

    links = console_config(config, cell=cell, local=at)
    taken = take_lease(links.cell, links.links.local, links.name, aside(as_json=as_json), links.links)
    tell_done(taken, as_json=as_json)


@lease_app.command("give")
def give(
    asker: Annotated[str, typer.Argument(help="Who asks for it, as 'farhand lease show' names them.")],
    cell: CellName = "",
    at: LocalEndpoint = "",
    remote: RemoteEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Consent: hand the lease to the operator of this name, who asks for it. The arm stops.

    Example: farhand lease give ben
    """
    from common.messages.requests import OperatorAction
    from farhand.authority.lease import find_asker

    links = console_config(config, cell=cell, local=at, control=remote)
    to = find_asker(links.cell, links.links.control, asker, links.links)
    _act_on_lease(OperatorAction.GIVE, links, to, as_json=as_json)


@lease_app.command("release")
def release(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None, as_json: AsJson = False) -> None:
    """Release the lease, so that any operator may take it. The arm stops.

    Example: farhand lease release
    """
    from common.messages.requests import OperatorAction

    _act_on_lease(OperatorAction.RELEASE, console_config(config, cell=cell, local=at), as_json=as_json)


def _act_on_lease(
    action: "OperatorAction", links: "ConsoleConfig", to: "Asker | None" = None, *, as_json: bool
) -> None:
    from farhand.authority.lease import act_on_lease

    tell_done(act_on_lease(links.cell, links.links.local, links.name, action, to, links.links), as_json=as_json)


@maintenance_app.command("stop")
def stop(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None, as_json: AsJson = False) -> None:
    """Stop the arm and refuse every engagement until it is reset; needs no lease.

    If it is not acknowledged the exit code is 1, as of 'farhand stop': use the emergency stop, which this never is.

    Example: farhand maintenance stop --config /etc/farhand/maintenance.toml
    """
    from farhand.authority.engage import or_unacknowledged

    with or_unacknowledged():
        _request_maintenance("stop", cell, at, config, as_json=as_json)


@maintenance_app.command("reset")
def reset(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None, as_json: AsJson = False) -> None:
    """Clear a stop or a fault, and wake a robot that has stopped; nothing moves until the operator engages.

    It says what it clears, such as who has stopped the arm, and clears nothing that came after that.

    Example: farhand maintenance reset --config /etc/farhand/maintenance.toml
    """
    _request_maintenance("reset", cell, at, config, as_json=as_json)


def _request_maintenance(action: str, cell: str, at: str, config: Path | None, *, as_json: bool) -> None:
    from common.messages.requests import EngagementAction
    from farhand.authority.engage import request_maintenance

    links = console_config(config, cell=cell, control=at)
    asked, beforehand = EngagementAction(action), aside(as_json=as_json)
    done = request_maintenance(links.cell, links.links.control, asked, beforehand, links.links)
    tell_done(done, as_json=as_json)
