"""Zenoh's access control, payload and rate caps, built from the table of channels; pure."""

from collections.abc import Iterator, Sequence
from enum import StrEnum
from typing import Any, NamedTuple

from common.link.channels import ANY, CHANNELS, PROCEDURES, Keyed
from common.link.endpoints import SECURED
from common.link.roles import Identity, Role

Json = dict[str, Any]
THIS_HOST = "this host"
QUERY_ROOM_BYTES = 512  # around a payload: an error sentence, an attachment that is never read
HEARING = ("ingress", "put"), ("egress", "declare_subscriber")
SENDING = ("egress", "put"), ("ingress", "declare_subscriber")
ANSWERING = ("ingress", "query"), ("egress", "reply"), ("egress", "declare_queryable")
ASKING = ("egress", "query"), ("ingress", "reply"), ("ingress", "declare_queryable")


class Serves(StrEnum):
    """Who is at the other ends of a session's links."""

    SITES = "sites"  # sites and router, no viewer
    VIEWERS = "viewers"  # viewers alone
    OWN_SITE = "own_site"  # the site or router that it watches for viewers; both have the same certificate
    LANE = "lane"  # the remote site alone (`lanes.py`): a router would send copies on by one connection


class Grant(NamedTuple):
    """One permission between this session and a neighbour: a flow, the kind of message, the key."""

    flow: str
    message: str
    key: str


class Encounter(NamedTuple):
    """A neighbour, and the roles in which this session and that one meet."""

    neighbour: Identity
    own: Role
    other: Role


def access_control(
    own: Identity, operators: Sequence[str], *, routed: bool, plain: bool, serves: Serves = Serves.SITES
) -> Json:
    """Refuse everything except what the table grants each role, by the common name of its certificate.

    `operators` are those who may operate the cell, each on the keys of that name only; an operator's own session serves
    nobody else. A remote site that is `routed` has no other neighbour than its cell's router; any other has no router.
    Viewers are neighbours of a session that `serves` them alone.
    With `plain` there are also links without certificates, on the loopback interface, whose neighbours may do what any
    role may.
    """
    operators = operators if own.operator is None else (own.operator,)
    rules, subjects, policies = [], [], []
    for neighbour, acts, other in _encounters(own, operators, routed=routed, serves=serves):
        name = neighbour.common_name
        names = operators if neighbour.operator is None else (neighbour.operator,)
        granted = _rules(name, set(grants(acts, other, own.cell, names)))
        if granted:
            rules += granted
            subjects.append({"id": name, "cert_common_names": [name], "link_protocols": list(SECURED)})
            policies.append({"rules": [rule["id"] for rule in granted], "subjects": [name]})
    if plain:
        names = (own.operator or ANY,)
        acts = Role.VIEWER if serves is Serves.OWN_SITE else own.role
        everything = {g for role in Role for g in grants(acts, role, own.cell, names)}
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


def grants(own: Role, neighbour: Role, cell: str, operators: Sequence[str]) -> Iterator[Grant]:
    """Yield what may pass between a session of one role and a neighbour of another, on the keys of these operators.

    A router acts for every role.
    """
    for channel in CHANNELS:
        if _is(neighbour, channel.sent_by) and _is(own, channel.received_by):
            yield from _granted(HEARING, channel, cell, operators)
        if _is(own, channel.sent_by) and _is(neighbour, channel.received_by):
            yield from _granted(SENDING, channel, cell, operators)
    for procedure in PROCEDURES:
        if _is(neighbour, procedure.asked_by) and _is(own, procedure.answered_by):
            yield from _granted(ANSWERING, procedure, cell, operators)
        if _is(own, procedure.asked_by) and _is(neighbour, procedure.answered_by):
            yield from _granted(ASKING, procedure, cell, operators)


def _encounters(own: Identity, operators: Sequence[str], *, routed: bool, serves: Serves) -> Iterator[Encounter]:
    """Yield who may be at the other end of a link, and in which role.

    Another session with a router's certificate is the process that serves its viewers: it may do no more than they.
    """
    if serves is Serves.VIEWERS:
        yield Encounter(Identity(Role.VIEWER, own.cell), own.role, Role.VIEWER)
    elif serves is Serves.OWN_SITE:
        yield Encounter(own, Role.VIEWER, own.role)
    else:
        for neighbour in _neighbours(own, operators, routed=routed):
            if serves is Serves.LANE and neighbour.role is not Role.REMOTE:
                continue
            both_route = own.role is Role.ROUTER and neighbour.role is Role.ROUTER
            yield Encounter(neighbour, own.role, Role.VIEWER if both_route else neighbour.role)


def _neighbours(own: Identity, operators: Sequence[str], *, routed: bool) -> Iterator[Identity]:
    """Yield the sites and routers that may be at the other end of a link.

    Only a remote site is told whether its link leads to a router.
    """
    for role in Role:
        if role is Role.VIEWER or (own.role is Role.REMOTE and routed != (role is Role.ROUTER)):
            continue
        if role is Role.OPERATOR:
            yield from (Identity(role, own.cell, operator) for operator in operators)
        else:
            yield Identity(role, own.cell)


def _granted(
    messages: tuple[tuple[str, str], ...], keyed: Keyed, cell: str, operators: Sequence[str]
) -> Iterator[Grant]:
    for operator in operators if keyed.by_operator else (ANY,):
        for flow, message in messages:
            yield Grant(flow, message, keyed.key_for(cell, operator=operator))


def _is(role: Role, allowed: frozenset[Role]) -> bool:
    return role in allowed or role is Role.ROUTER


def _rules(name: str, granted: set[Grant]) -> list[Json]:
    """Make a rule for each flow and kind of message."""
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
    """Drop messages larger than their channel allows on arrival, in all cells."""
    caps: list[tuple[tuple[str, ...], str, int]] = [
        (("put",), channel.key_for(ANY), channel.max_bytes) for channel in CHANNELS
    ]
    caps += [
        (("query", "reply"), procedure.key_for(ANY), procedure.max_bytes + QUERY_ROOM_BYTES) for procedure in PROCEDURES
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


def rate_caps(operators: Sequence[str]) -> list[Json]:
    """Drop questions that a neighbour asks too fast on arrival; a legitimate client asks again.

    Each of these operators has a cap of their own: a router is one neighbour for all of them.

    Samples are capped where they are taken instead (`Latest`): of a burst after a delay Zenoh would pass the first and
    drop the newest, and the arm would wait for the next.
    """
    rules = [
        {"key_expr": procedure.key_for(ANY, operator=operator), "freq": procedure.max_hz}
        for procedure in PROCEDURES
        for operator in ((operators or (ANY,)) if procedure.by_operator else (ANY,))
    ]
    return [{"id": "questions", "flows": ["ingress"], "messages": ["query"], "rules": rules}]


def no_waiting() -> list[Json]:
    """Drop questions and answers that a link cannot take; else whoever asks could make the answerer wait."""
    return [{"id": "questions", "messages": ["query"], "overwrite": {"congestion_control": "drop"}}]
