"""What stands for a site's process before the first."""


class Nobody:
    """A process that was never started."""

    lines: tuple[str, ...] = ()
    name = "nobody"
    exit_code = 0

    def end(self) -> None:
        """Nothing ends."""


NOBODY = Nobody()
