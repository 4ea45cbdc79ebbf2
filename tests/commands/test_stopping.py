"""The first Ctrl-C asks, the second ends."""

import os
import signal
import threading

import pytest

from workbench.commands.stopping import stop_on_interrupt


def press_ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)


def test_the_first_asks_to_stop_and_the_second_interrupts(capsys):
    before = signal.getsignal(signal.SIGINT)
    with stop_on_interrupt() as stopped:
        assert not stopped()
        press_ctrl_c()
        assert stopped()
        with pytest.raises(KeyboardInterrupt):
            press_ctrl_c()
    assert signal.getsignal(signal.SIGINT) is before
    assert "stopping with what is done" in capsys.readouterr().err


def test_what_was_there_before_is_there_afterwards():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ValueError), stop_on_interrupt():
        raise ValueError
    assert signal.getsignal(signal.SIGINT) is before


def test_another_thread_is_never_asked_to_stop():
    said = []

    def work():
        with stop_on_interrupt() as stopped:
            said.append(stopped())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert said == [False]
