"""How a client knows its server by TLS: the system's authorities, a file of them, or a hash."""

import hashlib
import hmac
import ssl
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError

FINGERPRINT = "sha256:"


@dataclass(frozen=True)
class Trust:
    """What a client accepts of a server.

    Attributes:
        context: for the connection; None without TLS.
        fingerprint: SHA-256 of the one certificate that is accepted; empty if authorities decide.
    """

    context: ssl.SSLContext | None = None
    fingerprint: bytes = b""

    def check(self, certificate: bytes | None) -> None:
        """Compare the certificate that the server showed with the one that is accepted.

        Args:
            certificate: in DER.

        Raises:
            WorkbenchError: if it is another.
        """
        if not self.fingerprint:
            return
        shown = hashlib.sha256(certificate or b"").digest()
        if not hmac.compare_digest(shown, self.fingerprint):
            raise WorkbenchError(
                f"the server's certificate has the fingerprint {FINGERPRINT}{shown.hex()}, which "
                "is not the one that was given: connect only if its owner tells you that one"
            )


def make_trust(tls: str | bool | None) -> Trust:
    """Return what a client accepts.

    Args:
        tls: None or False for no TLS, True for the system's authorities, the path of a file of
            certificates (PEM) to trust, or `sha256:` and the fingerprint of the server's own.

    Raises:
        WorkbenchError: if the file cannot be read, or the fingerprint is none.
    """
    if not tls:
        return Trust()
    if tls is True:
        return Trust(ssl.create_default_context())
    if tls.startswith(FINGERPRINT):
        return _by_fingerprint(tls)
    try:
        return Trust(ssl.create_default_context(cafile=tls))
    except OSError as error:  # ssl.SSLError is one
        reason = "is no file" if not Path(tls).is_file() else f"holds no certificates ({error})"
        raise WorkbenchError(
            f"{tls}: {reason}: name a file of certificates (PEM), or {FINGERPRINT}FINGERPRINT"
        ) from None


def _by_fingerprint(tls: str) -> Trust:
    digits = tls.removeprefix(FINGERPRINT).replace(":", "")
    try:
        fingerprint = bytes.fromhex(digits)
    except ValueError:
        fingerprint = b""
    if len(fingerprint) != hashlib.sha256().digest_size:
        raise WorkbenchError(
            f"'{tls}' is no fingerprint: write {FINGERPRINT} and 64 hexadecimal digits, as "
            "`openssl x509 -fingerprint -sha256 -noout -in CERTIFICATE` prints them"
        )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False  # the one certificate is known, whatever it calls itself
    context.verify_mode = ssl.CERT_NONE
    return Trust(context, fingerprint)
