"""What is written in the server's form, and what is wrong with it."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.gui.typed_number import read_whole_number
from workbench.link.address import DEFAULT_PORT, LOOPBACK
from workbench.link.server.config import ServerConfig

GROUP = "server"


@dataclass(frozen=True)
class ServerFields:
    """The form as it is written; the names are those of its fields.

    Attributes:
        host: where to listen.
        port: of TCP, as a text.
        token_file: path, "" without login.
        tls_cert: path of the certificate, "" without TLS.
        tls_key: path of its key.
        allow_commands: whether clients may fly.
        web: whether a page for phones is served.
    """

    host: str = LOOPBACK
    port: str = str(DEFAULT_PORT)
    token_file: str = ""
    tls_cert: str = ""
    tls_key: str = ""
    allow_commands: bool = True
    web: bool = False

    def config(self) -> ServerConfig:
        """Return what a server is to do; its `check` says whether it can be had."""
        try:
            port: int | str = read_whole_number(self.port)
        except WorkbenchError:
            port = self.port
        return ServerConfig(
            host=self.host,
            port=port,  # type: ignore[arg-type]
            token_file=self.token_file,
            tls_cert=self.tls_cert,
            tls_key=self.tls_key,
            allow_commands=self.allow_commands,
            web=self.web,
        )


def written_faults(fields: ServerFields) -> Mapping[str, str]:
    """Return what is wrong, by field, without a look at any file."""
    config, faults = fields.config(), {}
    if said := _refusal(ServerConfig(port=config.port).check):
        faults["port"] = said
    if said := _refusal(ServerConfig(host=config.host).check):
        # A host that is none is said before all else; what is left is that others can reach it.
        first = _refusal(ServerConfig(host=config.host, clients=0).check)
        if said == first:
            faults["host"] = said
        elif not config.token_file:
            faults["token_file"] = said
    return faults


def file_faults(fields: ServerFields) -> Mapping[str, str]:
    """Return what is wrong with files that are named, by field; they are small, and read here."""
    config, faults = fields.config(), {}
    if said := _no_plain_file(config.token_file) or _refusal(config.tokens):
        faults["token_file"] = said
    if said := _no_plain_file(config.tls_cert):
        faults["tls_cert"] = said
    elif said := _no_plain_file(config.tls_key) or _refusal(config.tls):
        faults["tls_key"] = said
    return faults


def read_fields(store: QSettings) -> ServerFields:
    """Return the fields as they were kept, or the defaults."""
    found: dict[str, str | bool] = {}
    for name, default in asdict(ServerFields()).items():
        kept = str(store.value(f"{GROUP}/{name}", default))
        found[name] = kept.lower() == "true" if isinstance(default, bool) else kept
    return ServerFields(**found)  # type: ignore[arg-type]


def keep_fields(store: QSettings, fields: ServerFields) -> None:
    """Keep the fields for the next start; of tokens and keys only the paths."""
    for name, value in asdict(fields).items():
        store.setValue(f"{GROUP}/{name}", value)


def _no_plain_file(path: str) -> str:
    """Return why a path cannot be read without waiting, as for a pipe; "" if it can."""
    if not path:
        return ""
    try:
        odd = Path(path).exists() and not Path(path).is_file()
    except (OSError, ValueError):  # whoever opens it says what is wrong with it
        return ""
    return f"{path}: is no plain file: choose another" if odd else ""


def _refusal(check: Callable[[], object]) -> str:
    try:
        check()
    except WorkbenchError as error:
        return str(error)
    return ""
