"""The operator's settings in force, with what the operating page has changed since under the lease held here; pure."""

from msgspec.structs import replace

from common.clock import NS_PER_S
from common.messages.hand import OperatorSettings
from local_site.console.model.page_messages import NewOrigins, Steer

NO_LEASE = 0
CONFIRMED_WITHIN_NS = NS_PER_S


class LeasedSettings:
    """`newest` are the settings in force, or as changed here, None until known; `lease` is the one held here."""

    def __init__(self) -> None:
        self.newest: OperatorSettings | None = None
        self.lease = NO_LEASE
        self._changed_ns = 0

    @property
    def own(self) -> OperatorSettings | None:
        """The settings of the lease that this console's operator holds; None without one, or while they are unknown."""
        newest = self.newest
        return newest if newest is not None and newest.lease == self.lease else None

    def adopt(self, in_force: OperatorSettings | None, lease: int, now_ns: int) -> bool:
        """Take the settings in force, unless they were just changed here; return whether a change is dropped.

        A change that is not in force after a second is dropped: it must not take effect when nobody expects it.
        """
        self.lease = lease
        ours = self.own
        is_newer = ours is not None and in_force is not None and ours.revision > in_force.revision
        if is_newer and now_ns - self._changed_ns <= CONFIRMED_WITHIN_NS:
            return False
        self.newest = in_force
        return is_newer

    def change(self, message: NewOrigins | Steer, now_ns: int) -> bool:
        """Change the settings under the lease held here; return whether there are any: else nothing is changed."""
        settings = self.own
        if settings is None:
            return False
        self._changed_ns = now_ns
        if isinstance(message, Steer):
            self.newest = message.apply(settings)
        else:
            self.newest = replace(settings, revision=settings.revision + 1)
        return True
