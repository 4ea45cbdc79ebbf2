"""What is wrong with a server's form, and what a colleague types, without a window."""

import hashlib
import ssl
import subprocess
from dataclasses import replace

import pytest
from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.gui.server.connect_panel import connect_line, fingerprint, reachable_address
from workbench.gui.server.refusals_panel import (
    MAX_REFUSAL_LINES,
    RefusalsPanel,
    refusal_counts_text,
)
from workbench.gui.server.server_control import ListeningState, server_state
from workbench.gui.server.server_form import (
    file_faults,
    read_config,
    read_port,
    save_config,
    written_faults,
)
from workbench.link.authentication import write_tokens
from workbench.link.backplane import ServerStatus
from workbench.link.server.config import ServerConfig
from workbench.live.messages import NetworkView, Phase
from workbench.live.view import LiveView


@pytest.fixture
def tokens(tmp_path):
    path = tmp_path / "link.tokens"
    write_tokens(path)
    return str(path)


@pytest.mark.parametrize("port", ["99999", "-1", "x", "", "7733.5", "²"])
def test_a_port_that_is_none_is_said_as_the_server_says_it(port):
    faults = written_faults(ServerConfig(port=read_port(port)))
    assert faults == {"port": f"the port {port} is not a number from 0 to 65535"}


def test_a_host_that_is_none_is_said_beside_the_host():
    faults = written_faults(ServerConfig(host="my host"))
    assert list(faults) == ["host"]
    assert "is not a host" in faults["host"]
    assert list(written_faults(ServerConfig(host=""))) == ["host"]


def test_a_host_for_others_wants_tokens_and_tls(tokens):
    said = {}
    for name, file in (("token_file", ""), ("tls_cert", tokens)):
        with pytest.raises(WorkbenchError) as refused:
            ServerConfig(host="0.0.0.0", token_file=file).check()
        said[name] = str(refused.value)
    assert written_faults(ServerConfig(host="0.0.0.0")) == said
    with_tokens = ServerConfig(host="0.0.0.0", token_file=tokens)
    assert written_faults(with_tokens) == {"tls_cert": said["tls_cert"]}
    assert written_faults(replace(with_tokens, tls_cert="c.pem", tls_key="k.pem")) == {}


def test_several_faults_are_said_at_once():
    faults = written_faults(ServerConfig(host="0.0.0.0", port=70000))
    assert set(faults) == {"port", "token_file", "tls_cert"}


def test_files_that_cannot_be_used_are_said(tmp_path, tokens):
    missing = str(tmp_path / "none.tokens")
    assert "cannot be read" in file_faults(ServerConfig(token_file=missing))["token_file"]
    assert file_faults(ServerConfig(token_file=tokens)) == {}
    faults = file_faults(ServerConfig(tls_cert=tokens))
    assert faults == {"tls_key": "TLS needs a certificate and its key: give the key, too"}
    both = file_faults(ServerConfig(tls_cert=tokens, tls_key=tokens))
    assert "not a certificate (PEM)" in both["tls_key"]


def test_a_pipe_is_not_waited_for(tmp_path):
    subprocess.run(["mkfifo", tmp_path / "pipe"], check=True)
    faults = file_faults(ServerConfig(tls_cert=str(tmp_path / "pipe"), tls_key="x"))
    assert "not a plain file" in faults["tls_cert"]


def test_fields_are_kept(tmp_path):
    path = str(tmp_path / "s.ini")
    written = ServerConfig("0.0.0.0", 7800, "a.tokens", "c.pem", "k.pem", False, True)
    store = QSettings(path, QSettings.Format.IniFormat)
    save_config(store, written)
    store.sync()
    assert read_config(QSettings(path, QSettings.Format.IniFormat)) == written
    assert read_config(QSettings(path + "x", QSettings.Format.IniFormat)) == ServerConfig()


def test_a_port_is_read_as_a_number():
    assert read_port(str(ServerConfig().port)) == ServerConfig().port
    assert read_port("0") == 0


def test_the_line_to_type_names_what_a_client_needs(tmp_path):
    assert (
        connect_line("10.0.0.5:7733", ServerConfig()) == "workbench gateway foxglove 10.0.0.5:7733"
    )
    certificate = tmp_path / "c.pem"
    certificate.write_text(ssl.DER_cert_to_PEM_cert(b"not a real one, but its bytes"))
    hexadecimal = hashlib.sha256(b"not a real one, but its bytes").hexdigest()
    config = ServerConfig(token_file="link.tokens", tls_cert=str(certificate))
    assert connect_line("h:1", config) == (
        f"workbench gateway foxglove h:1 --token-file FILE --tls sha256:{hexadecimal}"
    )
    assert fingerprint(str(tmp_path / "gone.pem")) == "sha256:FINGERPRINT"


def test_an_address_that_means_all_is_said_as_one_that_can_be_typed():
    assert reachable_address("127.0.0.1:7733") == "127.0.0.1:7733"
    host, _, port = reachable_address("0.0.0.0:7733").rpartition(":")
    assert port == "7733"
    assert host != "0.0.0.0"


def test_the_list_takes_each_refusal_once_and_has_an_end(qtbot):
    panel = RefusalsPanel()
    qtbot.addWidget(panel)

    def lines():
        return [line.partition("  ")[2] for line in panel.list.toPlainText().splitlines()]

    def report(told, count):
        panel.show_server(ServerStatus("127.0.0.1:7733", "", (), {"x": count}, tuple(told)))

    report("ab", 2)
    report("ab", 2)
    assert lines() == ["a", "b"]
    report("bb", 3)  # the same words once more
    report("abc", 10)
    assert lines() == ["a", "b", "b", "… 4 more, too many to list", "a", "b", "c"]
    for turn in range(2 * MAX_REFUSAL_LINES):
        report([str(turn)], 11 + turn)
    assert len(lines()) == MAX_REFUSAL_LINES
    panel.show_server(None)
    report(["new"], 1)
    assert lines()[-1] == "new" and panel.counts.text().endswith("x 1×.")


def test_refusals_are_counted_in_words():
    assert refusal_counts_text({}) == "Nothing was refused."
    said = refusal_counts_text({"too_fast": 1, "bad_login": 3})
    assert said == "Refused since the server's start: bad login 3×, too fast 1×."
    said = refusal_counts_text({"magic": 2, "tls": 1})
    assert said == "Refused since the server's start: other protocol 2×, TLS 1×."


def test_the_state_is_a_word_and_a_sentence():
    served = LiveView(
        Phase.FLYING, "", network=NetworkView(ServerStatus("127.0.0.1:7733", "", (), {}, ()))
    )
    idle = LiveView(Phase.FLYING, "")
    nothing = None
    assert server_state(idle, False, nothing, "")[0] is ListeningState.NO_FLIGHT
    assert server_state(idle, True, nothing, "")[0] is ListeningState.STOPPED
    assert server_state(idle, True, ListeningState.STARTING, "")[0] is ListeningState.STARTING
    assert server_state(served, True, nothing, "")[1] == ("at 127.0.0.1:7733; nobody is connected.")
    assert server_state(served, True, ListeningState.STOPPING, "")[0] is ListeningState.STOPPING
    failed = server_state(idle, True, nothing, "port 7733 is in use: take another")
    assert failed[0] is ListeningState.FAILED
    assert failed[1] == "Port 7733 is in use: take another."
    again = LiveView(Phase.FLYING, "", network=NetworkView(starts_again=True))
    begun = server_state(again, True, nothing, "the server was killed; it is started again")
    assert begun[0] is ListeningState.STARTING
    assert begun[1] == "The server was killed; it is started again."
