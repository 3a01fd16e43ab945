"""Zenoh's access control, payload and rate caps, made of the table of channels; pure."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from common.link.channels import (
    CHANNELS,
    PROCEDURES,
    Channel,
    Procedure,
)
from common.link.endpoints import SECURED
from common.link.roles import Identity, Role

Json = dict[str, Any]
THIS_HOST = "this host"
EVERY_CELL = "*"
QUERY_ROOM_BYTES = 512  # around a payload: an error sentence, an attachment that nobody reads


class Grant(NamedTuple):
    """What may pass between this session and a neighbour: a flow, the kind of message, the key."""

    flow: str
    message: str
    key: str


def access_control(own: Identity, cells: Sequence[str], *, plain: bool) -> Json:
    """Everything is refused but what the table grants each role, by the common name of its certificate.

    `cells` are those that this session serves, one but for a router. `plain` says that there are links without
    certificates too, on the loopback interface: who speaks there may do what every role may.
    """
    neighbours: list[tuple[Identity, tuple[str, ...]]] = [
        (Identity(role, cell), (cell,)) for cell in cells for role in Role if role is not Role.ROUTER
    ]
    neighbours.append((Identity(Role.ROUTER, None), tuple(cells)))
    rules, subjects, policies = [], [], []
    for neighbour, theirs in neighbours:
        name = neighbour.common_name
        granted = _rules(name, {g for cell in theirs for g in grants(own.role, neighbour.role, cell)})
        if granted:
            rules += granted
            subjects.append({"id": name, "cert_common_names": [name], "link_protocols": list(SECURED)})
            policies.append({"rules": [rule["id"] for rule in granted], "subjects": [name]})
    if plain:
        everything = {g for cell in cells for role in Role for g in grants(own.role, role, cell)}
        granted = _rules(THIS_HOST, everything)
        rules += granted
        subjects.append({"id": THIS_HOST, "link_protocols": ["tcp"]})
        policies.append({"rules": [rule["id"] for rule in granted], "subjects": [THIS_HOST]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def grants(own: Role, neighbour: Role, cell: str) -> Iterator[Grant]:
    """What may pass between a session of one role and a neighbour of another; a router stands for every role."""
    for channel in CHANNELS:
        yield from _channel_grants(channel, own, neighbour, cell)
    for procedure in PROCEDURES:
        yield from _procedure_grants(procedure, own, neighbour, cell)


def _channel_grants(channel: Channel[Any], own: Role, neighbour: Role, cell: str) -> Iterator[Grant]:
    key = channel.key_for(cell)
    if _is(neighbour, channel.sent_by) and _is(own, channel.heard_by):
        yield Grant("ingress", "put", key)
        yield Grant("egress", "declare_subscriber", key)
    if _is(own, channel.sent_by) and _is(neighbour, channel.heard_by):
        yield Grant("egress", "put", key)
        yield Grant("ingress", "declare_subscriber", key)


def _procedure_grants(procedure: Procedure[Any, Any], own: Role, neighbour: Role, cell: str) -> Iterator[Grant]:
    key = procedure.key_for(cell)
    if _is(neighbour, procedure.asked_by) and _is(own, procedure.answered_by):
        yield Grant("ingress", "query", key)
        yield Grant("egress", "reply", key)
        yield Grant("egress", "declare_queryable", key)
    if _is(own, procedure.asked_by) and _is(neighbour, procedure.answered_by):
        yield Grant("egress", "query", key)
        yield Grant("ingress", "reply", key)
        yield Grant("ingress", "declare_queryable", key)


def _is(role: Role, allowed: frozenset[Role]) -> bool:
    return role in allowed or role is Role.ROUTER


def _rules(name: str, granted: set[Grant]) -> list[Json]:
    """A rule for each flow and kind of message."""
    kinds = sorted({(grant.flow, grant.message) for grant in granted})
    return [
        {
            "id": f"{name}: {flow} {message}",
            "permission": "allow",
            "flows": [flow],
            "messages": [message],
            "key_exprs": sorted(g.key for g in granted if (g.flow, g.message) == (flow, message)),
        }
        for flow, message in kinds
    ]


def payload_caps() -> list[Json]:
    """What is larger than its channel allows is dropped on arrival, before anybody keeps it, in all cells."""
    caps: list[tuple[tuple[str, ...], str, int]] = [
        (("put",), channel.key_for(EVERY_CELL), channel.max_bytes) for channel in CHANNELS
    ]
    caps += [
        (("query", "reply"), procedure.key_for(EVERY_CELL), procedure.max_bytes + QUERY_ROOM_BYTES)
        for procedure in PROCEDURES
    ]
    return [
        {
            "id": f"cap of {key}",
            "flows": ["ingress"],
            "messages": list(messages),
            "key_exprs": [key],
            "size_limit": most,
        }
        for messages, key, most in caps
    ]


def rate_caps() -> list[Json]:
    """Questions that a neighbour asks faster than it may are dropped on arrival; who asked in earnest asks again.

    Samples are capped where they are taken instead (`Latest`): of those that delay has bunched Zenoh would let the
    first pass and drop the newest, and the arm would wait for the next.
    """
    rules = [{"key_expr": procedure.key_for(EVERY_CELL), "freq": procedure.most_hz} for procedure in PROCEDURES]
    return [{"id": "questions", "flows": ["ingress"], "messages": ["query"], "rules": rules}]
