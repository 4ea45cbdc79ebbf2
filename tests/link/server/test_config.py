import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.server.config import ServerConfig, is_loopback


def tokens(folder):
    path = folder / "tokens"
    path.write_text("view: " + "v" * 20 + "\ncommand: " + "c" * 20 + "\n")
    path.chmod(0o600)
    return str(path)


def test_the_default_listens_to_this_machine_only():
    config = ServerConfig()
    config.check()
    assert (config.host, config.port) == ("127.0.0.1", 7733)
    assert config.is_local
    assert config.tokens() is None
    assert config.tls() is None


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "drone.local", "8.8.8.8"])
def test_where_others_reach_it_tokens_and_tls_are_needed(tmp_path, host, certificate):
    cert, key = certificate
    tls = {"tls_cert": cert, "tls_key": key}
    for more in ({}, tls):
        with pytest.raises(WorkbenchError, match=f"others can reach {host}.*token file"):
            ServerConfig(host, **more).check()
    token_file = tokens(tmp_path)
    with pytest.raises(WorkbenchError, match=f"others can reach {host}.*without TLS.*: openssl"):
        ServerConfig(host, token_file=token_file).check()
    ServerConfig(host, token_file=token_file, **tls).check()


def test_the_command_for_a_certificate_names_where_it_is_served(tmp_path, case, monkeypatch):
    file = tokens(tmp_path)
    for own in ("192.168.1.7", None):
        monkeypatch.setattr("workbench.link.server.config.lan_address", lambda _, own=own: own)
        for host, name in [
            ("192.168.1.5", "IP:192.168.1.5"),
            ("fd00::5", "IP:fd00::5"),
            ("drone.local", "DNS:drone.local"),
            ("0.0.0.0", f"IP:{own or '0.0.0.0'}"),
        ]:
            with case(host, own), pytest.raises(WorkbenchError, match=f"subjectAltName={name} -"):
                ServerConfig(host, token_file=file).check()


def test_what_cannot_be_had_is_said_in_a_sentence(case):
    for config, said in [
        (ServerConfig(""), "is not a host"),
        (ServerConfig("a b"), "'a b' is not a host"),
        (ServerConfig("http://x"), "is not a host"),
        (ServerConfig(port=65536), "the port 65536 is not a number"),
        (ServerConfig(port=-1), "the port -1 is not a number"),
        (ServerConfig(web_port=70000), "the port of the page 70000 is not a number"),
        (ServerConfig(web=True, port=7000, web_port=7000), "cannot both have the port 7000"),
        (ServerConfig(clients=0), "clients is 0"),
        (ServerConfig(token_file="/nowhere/tokens"), "/nowhere/tokens"),
        (ServerConfig(tls_cert="a.pem"), "give the key, too"),
        (ServerConfig(tls_key="a.pem"), "give the certificate, too"),
        (ServerConfig(tls_cert="/nowhere/a", tls_key="/nowhere/b"), "/nowhere/a: no such file"),
    ]:
        with case(config, said), pytest.raises(WorkbenchError, match=said):
            config.check()


def test_a_token_file_that_others_may_read_is_refused(tmp_path):
    path = tokens(tmp_path)
    (tmp_path / "tokens").chmod(0o644)
    with pytest.raises(WorkbenchError, match="0644"):
        ServerConfig(token_file=path).check()


def test_what_is_no_certificate_is_refused(tmp_path):
    (tmp_path / "a.pem").write_text("nothing")
    path = str(tmp_path / "a.pem")
    with pytest.raises(WorkbenchError, match="are not a certificate"):
        ServerConfig(tls_cert=path, tls_key=path).check()


def test_what_counts_as_this_machine(case):
    for host, local in [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("localhost", True),
        ("LocalHost", True),
        ("localhost.evil.com", False),
        ("0.0.0.0", False),
        ("::", False),
        ("::ffff:10.0.0.1", False),
        ("10.0.0.1", False),
        ("fe80::1%eth0", False),
        ("127.0.0.1.evil.com", False),
    ]:
        with case(host, local):
            assert is_loopback(host) is local
