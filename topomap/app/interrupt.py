"""Signals that would end the program as a wish to stop between two steps, so that nothing is cut in half."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

NAMES = (
    *("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF"),
    *("SIGXCPU", "SIGIO", "SIGPWR", "SIGSTKFLT"),
)
"""What ends a program that doesn't listen: from the keyboard, a closed terminal, a service manager, a timer."""
SIGNALS = tuple(getattr(signal, name) for name in NAMES if hasattr(signal, name))
IMPATIENT = (signal.SIGINT, signal.SIGQUIT)
"""From the keyboard: a second one interrupts at once. Others come in pairs (a closed terminal sends two)."""


class Stop:
    """Whether a signal came, and which one was the first."""

    def __init__(self) -> None:
        self.number: int | None = None

    def __call__(self) -> bool:
        return self.number is not None

    def note(self, number: int, _: FrameType | None) -> None:
        """Take a signal; raises KeyboardInterrupt for a second one from the keyboard."""
        if self.number is not None and number in IMPATIENT:
            raise KeyboardInterrupt
        if self.number is None:
            self.number = number


@contextmanager
def stop_on_signal() -> Iterator[Stop]:
    """Yield what says whether a signal came; a second one from the keyboard interrupts at once.

    Only the main thread hears signals: in another one none ever comes. What is ignored (nohup) stays so.
    """
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    heard = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, stop.note) for number in heard}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
