"""The operator's page: what it has set under the lease in force, its clutch, and whether it still reports; pure."""

from common.messages.hand import Intent, OperatorSettings
from remote_site.session.clutch import Clutch


class OperatorPage:
    """Keeps `settings` under the number of their lease, whatever happens to the page, console or pedal that sent them.

    Only a higher revision under the same lease replaces them: a console that starts again cannot overwrite them by
    defaults, nor one that has missed a change.
    """

    def __init__(self) -> None:
        self.settings = OperatorSettings()
        self.clutch = Clutch()
        self._has_reported = self._reports = False

    @property
    def silent(self) -> bool:
        """A page has reported under this lease, and the newest sample comes without it."""
        return self._has_reported and not self._reports

    def begin(self, lease: int) -> None:
        """Take note of the number of the lease in force; a new one begins with the defaults, and without a page."""
        if lease != self.settings.lease:
            self.settings = OperatorSettings(lease=lease)
            self.clutch = Clutch()
            self._has_reported = self._reports = False

    def see(self, intent: Intent | None) -> None:
        """Take what the page reported for the newest sample, None where it reported nothing."""
        self._reports = intent is not None
        self._has_reported = self._has_reported or self._reports
        self.settings = self.settings.followed_by(intent.settings if intent is not None else None)
