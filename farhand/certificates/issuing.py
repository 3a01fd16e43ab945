"""Makes keys and X.509 certificates, the authority's own and those it issues; no I/O, but random keys and serials."""

import ipaddress
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from common.link.roles import LISTENERS, Identity

CLOCK_TOLERANCE = timedelta(minutes=5)  # certificates are backdated: another host's clock may be behind by this
CA_DAYS = 3650


@dataclass(frozen=True, slots=True)
class Issued:
    """A certificate with its private key."""

    certificate: x509.Certificate
    key: ec.EllipticCurvePrivateKey

    @property
    def certificate_pem(self) -> bytes:
        """The certificate as PEM."""
        return self.certificate.public_bytes(serialization.Encoding.PEM)

    @property
    def key_pem(self) -> bytes:
        """The key as PEM, not encrypted: a daemon that starts by itself cannot ask for a password."""
        return self.key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )


def make_authority(name: str, now: datetime) -> Issued:
    """A self-signed certificate authority, valid for CA_DAYS from `now` (UTC); it may not sign further authorities."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = _distinguished_name(name)
    certificate = (
        _builder(subject, subject, key.public_key(), now, timedelta(days=CA_DAYS))
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(_key_usage(signs_certificates=True), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    return Issued(certificate, key)


def issue(authority: Issued, identity: Identity, hosts: Sequence[str], now: datetime, valid: timedelta) -> Issued:
    """A certificate for a role at a cell, a client's, and a server's too where that role listens.

    It is valid for `valid` from `now` (UTC); `hosts` are the names or IP addresses under which others reach the holder.
    """
    key = ec.generate_private_key(ec.SECP256R1())
    issuer_key = authority.key.public_key()
    alternative_names = x509.SubjectAlternativeName([_general_name(host) for host in hosts])
    as_server = [ExtendedKeyUsageOID.SERVER_AUTH] if identity.role in LISTENERS else []
    uses = x509.ExtendedKeyUsage([*as_server, ExtendedKeyUsageOID.CLIENT_AUTH])
    certificate = (
        _builder(_distinguished_name(identity.common_name), authority.certificate.subject, key.public_key(), now, valid)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(alternative_names, critical=False)
        .add_extension(uses, critical=False)
        .add_extension(_key_usage(signs_certificates=False), critical=True)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer_key), critical=False)
        .sign(authority.key, hashes.SHA256())
    )
    return Issued(certificate, key)


def _general_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, now: datetime, valid: timedelta
) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCK_TOLERANCE)
        .not_valid_after(now + valid)
    )


def _distinguished_name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _key_usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )
