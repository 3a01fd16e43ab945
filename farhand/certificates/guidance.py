"""Guidance on certificates that have just been made, in words."""

from pathlib import Path

from common.text import toml_string
from farhand.certificates.authorities import SITES, VIEWERS
from farhand.certificates.folder import CertificateOrder


def guidance(folder: Path, order: CertificateOrder) -> str:
    """Say what to do with the new files."""
    cell, theirs, names = order.cell, folder / order.cell, order.operators or ("NAME",)
    where = order.hosts[0] if order.hosts else "127.0.0.1"
    made = ["remote", "maintenance", *(f"operator.{name}" for name in order.operators), "viewer", "viewers-remote"]
    return (
        f"made in {theirs}: a certificate and key each for {', '.join(made)}\n"
        f"for every further operator: farhand certificates operator {cell} NAME --dir {folder}\n"
        f"for a router, where the sites cannot reach each other: farhand certificates router {cell} --dir {folder}\n"
        f"keep {folder / SITES.stem}.key secret: anybody who has it can become an operator\n"
        "give each host ca.pem and its own pair, keys for the service's user only, for the robot's side:\n"
        f'  cell = "{cell}"\n'
        "  [links]\n"
        '  control = "tls/0.0.0.0:7447"\n'
        '  video = "tls/0.0.0.0:7448"\n'
        f"  operators = [{', '.join(toml_string(name) for name in names)}]\n"
        "  [links.tls]\n"
        f'  ca = "/etc/farhand/{SITES.stem}.pem"\n'
        '  certificate = "/etc/farhand/remote.pem"\n'
        '  key = "/etc/farhand/remote.key"\n'
        "where others are to watch, it needs the viewers' authority too, and a pair of that for their listener:\n"
        "  [links.viewers]\n"
        '  listen = "tls/0.0.0.0:7449"\n'
        "  [links.viewers.tls]\n"
        f'  ca = "/etc/farhand/{VIEWERS.stem}.pem"\n'
        '  certificate = "/etc/farhand/viewers-remote.pem"\n'
        '  key = "/etc/farhand/viewers-remote.key"\n'
        f"a host that only watches has {VIEWERS.stem}.pem, viewer.pem and viewer.key, and that endpoint for "
        "control and video\n"
        f'and for an operator\'s, with operator.{names[0]}.pem and .key: the same cell, remote = "tls/{where}:7447", '
        f'and in [authority] operator = "{names[0]}"'
    )
