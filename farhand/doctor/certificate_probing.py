"""Reads what a configuration names in [links.tls]."""

from datetime import datetime
from pathlib import Path

from cryptography import x509

from common.errors import ConfigError, TransportError
from common.link.config import TlsConfig
from common.link.credentials import load_credentials
from farhand.certificates.folder import read_certificate
from farhand.doctor.certificates import CertificateFacts

SECONDS_PER_DAY = 86400.0
MODE_BITS = 0o777


def probe_certificate(tls: TlsConfig, now: datetime) -> CertificateFacts:
    """Shake hands with the files as a link would, then look at dates and modes."""
    try:
        identity = load_credentials(tls).identity
        certificate, authority = read_certificate(Path(tls.certificate)), read_certificate(Path(tls.ca))
    except (TransportError, ConfigError) as error:
        return CertificateFacts(tls.certificate, problem=str(error))
    return CertificateFacts(
        tls.certificate,
        identity.common_name,
        _days_left(certificate, now),
        _days_left(authority, now),
        Path(tls.key).stat().st_mode & MODE_BITS,
    )


def _days_left(certificate: x509.Certificate, now: datetime) -> float:
    return (certificate.not_valid_after_utc - now).total_seconds() / SECONDS_PER_DAY
