"""One remote and one local site for many tests, since starting them is what takes longest."""

from common.errors import TransportError
from common.messages.robot import SessionState
from farhand.authority.engage import request_engage
from farhand.loopback.site_process import SiteProcess, free_ports
from tests.integration.sites import CELL, PATIENT, Sites

OPERATOR = "anna"
LEASE_S = 3.0
MOVING_RAD_S = 0.05


class Pair:
    """The sites as one test leaves them to the next: what has ended is started again once it is needed."""

    def __init__(self, sites: Sites) -> None:
        self.sites = sites
        self.metrics_port = free_ports(1)[0]
        self._remote: SiteProcess | None = None
        self._local: SiteProcess | None = None

    def remote(self) -> SiteProcess:
        """The remote site, once it publishes its state."""
        before = len(self.sites.record.states)
        remote = self._started_remote()
        self.sites.wait("the remote site", lambda: len(self.sites.record.states) > before)
        return remote

    def untouched_remote(self) -> SiteProcess:
        """A remote site that no local site has met yet."""
        if self._local is not None:
            self.end()
        return self.remote()

    def local(self) -> SiteProcess:
        """The local site, once it sends hands."""
        before = len(self.sites.record.hands)
        if self._local is None or self._local.exit_code is not None:
            self._local = self.sites.local(f"authority.operator={OPERATOR}")
        self.sites.wait("a hand", lambda: len(self.sites.record.hands) > before)
        return self._local

    def following(self) -> tuple[SiteProcess, SiteProcess]:
        """Remote and local site, once the arm is engaged; that is asked for where it does not come by itself."""
        self._started_remote()
        local = self.local()
        remote = self.remote()
        self.sites.wait("the arm to be engaged", self._engaged)
        return remote, local

    def moving(self) -> tuple[SiteProcess, SiteProcess]:
        """The same, once the arm moves; a machine that ends the engagement meanwhile only delays it."""
        sites = self.following()
        self.sites.wait("the arm to move", lambda: self._engaged() and self.sites.speed() > MOVING_RAD_S)
        return sites

    def engage(self) -> str:
        """The answer to a request to engage; empty when it is refused."""
        try:
            return request_engage(CELL, self.sites.endpoints.control, OPERATOR)
        except TransportError:
            return ""

    def end(self) -> None:
        """Both sites, in order."""
        for process in (self._local, self._remote):
            if process is not None:
                process.end()
        self._local = None

    def _engaged(self) -> bool:
        if self.sites.state.readiness.ready and not self.sites.is_in(SessionState.ENGAGED):
            self.engage()
        return self.sites.is_in(SessionState.ENGAGED)

    def _started_remote(self) -> SiteProcess:
        if self._remote is None or self._remote.exit_code is not None:
            robot = "driver.name=kinematic", "engagement.mode=automatic"
            lease, metrics = f"lease.seconds={LEASE_S}", f"metrics.port={self.metrics_port}"
            self._remote = self.sites.remote(*robot, lease, metrics, *PATIENT)
        return self._remote
