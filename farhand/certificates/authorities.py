"""The two authorities of a folder, one for the sites and one for those who only watch: made once, and read."""

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from common.atomic_file import write_atomically
from common.errors import ConfigError
from farhand.certificates.issuing import Issued, make_authority

PRIVATE, PUBLIC = 0o600, 0o644


@dataclass(frozen=True, slots=True)
class CertificateAuthority:
    """An authority's files, by their stem, and the name in its certificate."""

    stem: str
    name: str


SITES = CertificateAuthority("ca", "Farhand certificate authority")
VIEWERS = CertificateAuthority("viewers-ca", "Farhand certificate authority for viewers")


def load_authority(folder: Path, authority: CertificateAuthority = SITES) -> Issued:
    """An authority kept in a folder; ConfigError when its files are missing or do not belong together."""
    path = folder / f"{authority.stem}.key"
    certificate = read_certificate(folder / f"{authority.stem}.pem")
    try:
        key = serialization.load_pem_private_key(path.read_bytes(), password=None)
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror}; it stays where the certificates were made") from error
    except (ValueError, TypeError) as error:
        raise ConfigError(f"{path} is not a private key: delete {folder} and create all certificates again") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise ConfigError(f"{path} is not the key of {folder / authority.stem}.pem: restore the one that is")
    return Issued(certificate, key)


def has_authority(folder: Path, authority: CertificateAuthority) -> bool:
    """Return whether the folder keeps the authority's key."""
    return (folder / f"{authority.stem}.key").exists()


def ensure_authority(folder: Path, authority: CertificateAuthority, now: datetime) -> Issued:
    """The authority kept in a folder, or a new one; ConfigError where only its certificate is there."""
    if has_authority(folder, authority):
        return load_authority(folder, authority)
    certificate = folder / f"{authority.stem}.pem"
    if certificate.exists():
        raise ConfigError(f"{folder} holds {certificate.name} but not its key: create where the key is kept")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    made = make_authority(authority.name, now)
    write_pair(certificate, made)
    return made


def read_certificate(path: Path) -> x509.Certificate:
    """The certificate in a PEM file, else ConfigError."""
    try:
        return x509.load_pem_x509_certificate(path.read_bytes())
    except OSError as error:
        raise ConfigError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError(f"{path} is not a certificate (PEM)") from error


def write_pair(certificate: Path, issued: Issued) -> None:
    """Write the key first: a certificate is useless without it."""
    write_atomically(certificate.with_suffix(".key"), issued.key_pem, PRIVATE)
    write_atomically(certificate, issued.certificate_pem, PUBLIC)
