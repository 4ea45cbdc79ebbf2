"""The first Ctrl-C asks, the second ends."""

import os
import signal
import threading

import pytest

from workbench.commands.stopping import STOP_SIGNALS, stop_on_interrupt


def press_ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)


def test_the_first_asks_to_stop_and_the_second_interrupts(capsys):
    before = signal.getsignal(signal.SIGINT)
    with stop_on_interrupt() as stopped:
        assert not stopped()
        press_ctrl_c()
        assert stopped()
        assert stopped.exit_code == 130
        with pytest.raises(KeyboardInterrupt):
            press_ctrl_c()
    assert signal.getsignal(signal.SIGINT) is before
    assert "stopping with what is done; press Ctrl-C again to quit" in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_system_that_ends_the_program_is_heard_as_ctrl_c(number, capsys):
    before = [signal.getsignal(each) for each in STOP_SIGNALS]
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as under nohup
    with stop_on_interrupt() as stopped:
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    signal.signal(signal.SIGHUP, before[-1])
    with stop_on_interrupt() as stopped:
        os.kill(os.getpid(), number)
        assert stopped()
        assert stopped.exit_code == 128 + number
    assert [signal.getsignal(each) for each in STOP_SIGNALS] == before
    assert "send the signal again to quit" in capsys.readouterr().err


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
