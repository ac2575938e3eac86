"""Ctrl-C as a normal way to stop."""

from __future__ import annotations

import os
import signal

import pytest

from twonav_cli.terminal.interrupt import StopOnInterrupt


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_only_asks_to_stop_and_says_so(
    number: signal.Signals, capfd: pytest.CaptureFixture[str]
) -> None:
    with StopOnInterrupt() as stop:
        assert not stop()
        os.kill(os.getpid(), number)
        assert stop()
    assert "saving first" in capfd.readouterr().err


def test_the_second_breaks_off() -> None:
    def twice() -> None:
        with StopOnInterrupt():
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        twice()


def test_afterwards_signals_mean_what_they_meant_before() -> None:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    with StopOnInterrupt():
        during = {number: signal.getsignal(number) for number in before}
    assert all(during[number] != before[number] for number in before)
    assert {number: signal.getsignal(number) for number in before} == before
