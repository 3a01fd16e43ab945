"""A Zenoh session that hears one cell alone: with certificates, only who has that of its remote site or router."""

import json
import re
import ssl
from pathlib import Path
from typing import Any

import zenoh

SENDERS = "remote", "router"  # of a state: the roles in the common name of a certificate, ROLE.CELL
LISTENING = ("ingress", "put"), ("egress", "declare_subscriber")
ASKING = ("egress", "query"), ("ingress", "reply"), ("ingress", "declare_queryable")
COMMON_NAME = re.compile(rb"\x06\x03\x55\x04\x03[\x0c\x13](.)", re.DOTALL)  # of a certificate: identifier, type, length


def open_session(cell: str, remote: str, ca: str, certificate: str, key: str) -> zenoh.Session:
    """A session that connects to one endpoint, listens nowhere, and looks for nobody."""
    config = zenoh.Config()
    settings: dict[str, Any] = {
        "mode": "peer",
        "connect/endpoints": [f"{remote}?mixed_rel=1" if remote.startswith("quic/") else remote],
        "connect/timeout_ms": -1,  # in the background, again and again
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2},
        "listen/endpoints": [],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    if ca:
        settings |= {
            "transport/link/tls/root_ca_certificate": ca,
            "transport/link/tls/connect_certificate": certificate,
            "transport/link/tls/connect_private_key": key,
            "transport/link/tls/enable_mtls": True,
            "transport/link/tls/verify_name_on_connect": True,
            "transport/link/tls/close_link_on_expiration": True,
            "access_control": _from_the_cell_alone(cell),
        }
    for path, value in settings.items():
        config.insert_json5(path, json.dumps(value))
    return zenoh.open(config)


def own_key(key: str, cell: str, certificate: str) -> str:
    """The key on which who has this certificate asks: an operator's ends in that operator's name.

    Without a certificate, and in the other roles, it is the `key` itself. ConnectionError where it cannot be read.
    """
    if not certificate:
        return key
    try:
        der, prefix = ssl.PEM_cert_to_DER_cert(Path(certificate).read_text()), f"operator.{cell}.".encode()
    except (OSError, ValueError) as error:
        raise ConnectionError(f"cannot read the certificate {certificate}: {error}") from error
    names = (der[found.end() :][: found[1][0]] for found in COMMON_NAME.finditer(der))
    name = next((name.removeprefix(prefix).decode() for name in names if name.startswith(prefix)), None)
    return key if name is None else f"{key}/{name}"


def stranger(session: zenoh.Session, cell: str) -> str | None:
    """The common name in the certificate of a listener that is neither the cell's remote site nor its router."""
    shown = (link.auth_identifier or "nobody" for link in session.info.links())
    return next((name for name in shown if name not in _names(cell)), None)


def _names(cell: str) -> list[str]:
    return [f"{role}.{cell}" for role in SENDERS]


def _from_the_cell_alone(cell: str) -> dict[str, Any]:
    """Access control: state and answers of the cell pass, whoever else has a certificate of the authority sends none.

    The authority of viewers trusts every viewer, and a link that comes back may lead to another listener.
    """
    state = [f"farhand/{cell}/state"]
    asked = [f"farhand/{cell}/{what}{whose}" for what in ("rpc/describe", "clock") for whose in ("", "/*")]
    passing = [(*kind, state) for kind in LISTENING] + [(*kind, asked) for kind in ASKING]
    rules = [
        {"id": f"{flow} {message}", "permission": "allow", "flows": [flow], "messages": [message], "key_exprs": keys}
        for flow, message, keys in passing
    ]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": "cell", "cert_common_names": _names(cell), "link_protocols": ["tls", "quic"]}],
        "policies": [{"rules": [rule["id"] for rule in rules], "subjects": ["cell"]}],
    }
