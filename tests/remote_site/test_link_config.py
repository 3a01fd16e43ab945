"""The endpoints of the remote site: which it has for viewers, and where it has none."""

import pytest

from common.link.config import TlsConfig, ViewersConfig
from remote_site.link_config import RemoteLinksConfig

VIEWERS = ViewersConfig(listen="tls/0.0.0.0:7449", tls=TlsConfig(ca="ca.pem", certificate="one.pem", key="one.key"))


def test_behind_a_router_viewers_connect_there_and_the_site_says_so() -> None:
    with pytest.raises(ValueError, match=r"viewers connect there: .* as \[viewers\], and leave it out here"):
        RemoteLinksConfig(router="tls/meet.example.org:7450", viewers=VIEWERS)


def test_viewers_add_no_endpoint_to_those_that_others_use() -> None:
    assert RemoteLinksConfig(viewers=VIEWERS).endpoints == RemoteLinksConfig().endpoints
    assert RemoteLinksConfig().viewers.listen == ""
