"""Whether a site's certificate protects its links, and how long still; pure judgements."""

from dataclasses import dataclass

from farhand.doctor.findings import Finding, error, ok, warning

SOON_DAYS = 30
GROUP, OTHERS = 0o070, 0o007
RENEW = "where the authority is kept: farhand certificates renew CELL; then copy the pair here and restart"


@dataclass(frozen=True, slots=True)
class CertificateFacts:
    """A certificate's file, whom it names, days until it and its authority expire, its key's mode; or what is wrong."""

    path: str
    names: str = ""
    days_left: float = 0.0
    authority_days_left: float = 0.0
    key_mode: int = 0
    problem: str = ""


def check_certificate(facts: CertificateFacts, expected: str) -> list[Finding]:
    """It is good now and for a while, it is for this site (`expected`), and nobody else can read its key."""
    if facts.problem:
        return [error("certificate", facts.problem, RENEW)]
    findings = [_expiry("certificate", f"{facts.path} of {facts.names}", facts.days_left, RENEW)]
    if facts.authority_days_left < SOON_DAYS:
        cure = "make a new authority in a new folder: farhand certificates create CELL --dir NEW, for all hosts at once"
        findings.append(_expiry("certificate authority", "it", facts.authority_days_left, cure))
    if facts.names != expected:
        findings.append(
            error(
                "certificate",
                f"{facts.path} is for {facts.names}, not for {expected}",
                "give this site its own certificate in the table [links.tls]",
            )
        )
    if facts.key_mode & (GROUP | OTHERS):
        judge = error if facts.key_mode & OTHERS else warning
        whose = "everybody on this host" if facts.key_mode & OTHERS else "its group"
        findings.append(judge("certificate key", f"{whose} can read the key of {facts.path}", "chmod 600 the key"))
    return findings


def _expiry(check: str, what: str, days: float, cure: str) -> Finding:
    sentence = f"{what} expires in {days:.0f} days"
    return warning(check, sentence, cure) if days < SOON_DAYS else ok(check, sentence)
