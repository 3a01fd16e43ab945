"""Where the programs of one cell meet, as the settings of each."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CellEndpoints:
    """A cell's name, and the endpoints of its remote site's control and pictures, and of its local site."""

    cell: str
    control: str
    video: str
    listen: str

    @classmethod
    def on_ports(cls, cell: str, control: int, video: int, listen: int) -> "CellEndpoints":
        """Choose these ports of this host, without certificates."""
        return cls(cell, *(f"tcp/127.0.0.1:{port}" for port in (control, video, listen)))

    @property
    def remote(self) -> tuple[str, ...]:
        """The settings of the remote site, and of its recorder."""
        return f"cell={self.cell}", f"links.control={self.control}", f"links.video={self.video}"

    @property
    def local(self) -> tuple[str, ...]:
        """The settings of the local site, and of its recorder."""
        return f"cell={self.cell}", f"links.remote={self.control}", f"links.listen={self.listen}"

    @property
    def console(self) -> tuple[str, ...]:
        """The settings of the console."""
        return *self.remote, f"links.local={self.listen}"
