"""A Zenoh session that hears one cell alone: with certificates, only who has that of its remote site or router."""

import json
from typing import Any

import zenoh

SENDERS = "remote", "router"  # of a state: the roles in the common name of a certificate, ROLE.CELL
LISTENING = ("ingress", "put"), ("egress", "declare_subscriber")
ASKING = ("egress", "query"), ("ingress", "reply"), ("ingress", "declare_queryable")


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
    state, asked = [f"farhand/{cell}/state"], [f"farhand/{cell}/rpc/describe", f"farhand/{cell}/clock"]
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
