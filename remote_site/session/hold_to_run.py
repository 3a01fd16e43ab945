"""The hold-to-run input, key or pedal: held only after it was seen let go; pure."""


class HoldToRun:
    """What the operator holds down; after `end`, only a new press counts: what has ended does not start by itself."""

    def __init__(self) -> None:
        self.held = False
        self.armed = False

    def see(self, held: bool) -> bool:
        """Take what a sample says; True when the input has just been let go."""
        let_go = self.held and not held
        self.armed = self.armed or not held
        self.held = held and self.armed
        return let_go

    def end(self) -> None:
        """The engagement, the lease or the sight of the operator has ended."""
        self.held = self.armed = False
