"""A scripted server for the tests of clients."""

import importlib.util
import shlex
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from workbench.link.page_address import lan_address
from workbench.link.server.config import MAKE_CERTIFICATE


def load_fake_server():
    """Return the module, which stands beside the tests and is no test."""
    name = "fake_link_server"
    if name not in sys.modules:
        path = Path(__file__).with_name("fake_server.py")
        spec = importlib.util.spec_from_file_location(name, path)
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


@pytest.fixture
def fakes():
    """Return the module of the fake server; nothing of a test may be left running."""
    before = set(threading.enumerate())
    yield load_fake_server()
    left = [each.name for each in set(threading.enumerate()) - before]
    assert not left, f"threads are left: {left}"


@pytest.fixture(scope="session")
def certificate(tmp_path_factory):
    """Return the paths of a certificate for this machine, made as the server says, and its key."""
    if not shutil.which("openssl"):
        pytest.skip("needs openssl")
    folder = tmp_path_factory.mktemp("certificate")
    names = ",".join(f"IP:{each}" for each in ("127.0.0.1", lan_address()) if each)
    command = shlex.split(MAKE_CERTIFICATE.format(name=names))
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return str(folder / "drone.pem"), str(folder / "drone.key")


@pytest.fixture
def server(fakes):
    """Return a running fake server without tokens."""
    server = fakes.FakeServer()
    yield server
    server.close()
