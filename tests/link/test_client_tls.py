"""TLS of a client: who vouches for the server, and what is said if nobody does."""

import asyncio
import hashlib
import ssl
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import AsyncClient, Client
from workbench.link.connection import make_trust


@pytest.fixture
def tls_server(fakes, certificate):
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*certificate)
    server = fakes.FakeServer(tls=context)
    yield server
    server.close()


def fingerprint(certificate):
    der = ssl.PEM_cert_to_DER_cert(Path(certificate[0]).read_text())
    return "sha256:" + hashlib.sha256(der).hexdigest()


def test_a_file_of_certificates_vouches(tls_server, certificate):
    with Client(tls_server.address, tls=certificate[0]) as client:
        assert client.ping() == 5.0


def test_a_fingerprint_vouches_however_it_is_written(tls_server, certificate):
    digits = fingerprint(certificate).removeprefix("sha256:").upper()
    pairs = ":".join(digits[at : at + 2] for at in range(0, 64, 2))
    for written in (fingerprint(certificate), f"sha256:{pairs}"):
        with Client(tls_server.address, tls=written) as client:
            assert client.ping() == 5.0


def test_another_fingerprint_is_refused(tls_server):
    with pytest.raises(WorkbenchError, match="not the one that was given"):
        Client(tls_server.address, tls="sha256:" + "0" * 64).__enter__()


def test_authorities_do_not_know_it(tls_server):
    with pytest.raises(WorkbenchError, match="certificate is not trusted .*: give the file"):
        Client(tls_server.address, tls=True).__enter__()


def test_a_server_without_tls_is_a_sentence(server):
    with pytest.raises(WorkbenchError, match="does not speak TLS .*: leave TLS out"):
        Client(server.address, tls=True).__enter__()


def test_a_client_without_tls_is_told_to_think_of_it(tls_server, monkeypatch):
    monkeypatch.setattr("workbench.link.connection.GREETING_TIMEOUT_S", 0.2)
    with pytest.raises(WorkbenchError, match="does it want TLS"):
        Client(tls_server.address).__enter__()


def test_a_client_whose_connection_is_closed_is_told_of_tls(monkeypatch):
    """As by a server that gets no TLS hello in time."""
    monkeypatch.setattr("workbench.link.connection.CROWD_RETRY_S", 0.0)

    async def refuse():
        server = await asyncio.start_server(lambda _, writer: writer.close(), "127.0.0.1", 0)
        host, port = server.sockets[0].getsockname()
        async with server, AsyncClient(f"{host}:{port}"):
            pass

    with pytest.raises(WorkbenchError, match="closed the connection; if it serves over TLS"):
        asyncio.run(refuse())


@pytest.mark.parametrize(
    ("tls", "said"),
    [
        ("missing.pem", "missing.pem: no such file"),
        ("empty.pem", "holds no certificates"),
        ("sha256:12", "is not a fingerprint"),
        ("sha256:" + "x" * 64, "is not a fingerprint"),
    ],
)
def test_what_vouches_for_nobody_is_a_sentence(tmp_path, monkeypatch, tls, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.pem").write_text("")
    with pytest.raises(WorkbenchError, match=said):
        make_trust(tls)
