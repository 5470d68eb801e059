"""A robot that is asked under a deadline: a driver that hangs doesn't leave the wheels turning."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TypeVar

from topomap.core.errors import RobotFault
from topomap.core.records import Command
from topomap.core.robot import Reading, Robot

T = TypeVar("T")
DEADLINE_S = 2.0
"""How long `sense` and `act` may take, and the stack from one command to the next [s]: 0.8 m at 0.4 m/s."""
FIRST_S = 60.0
"""How long the first reading may take [s]: a camera starts up, and the wheels stand still."""
GRACE_S = 0.3
"""How long a reading is still waited for once the run shall end [s]: a step of the slowest driver."""
SLICE_S = 0.02
STILL = Command(0.0, 0.0)


class GuardedRobot:
    """A robot whose calls are made in one thread of its own and waited for no longer than a deadline [s].

    Raises RobotFault when a call takes longer or fails. Where the stack itself takes longer for a step, the wheels are
    halted until its next command. `stop` is handed on once.
    """

    def __init__(self, robot: Robot, deadline_s: float = DEADLINE_S) -> None:
        self._robot = robot
        self._deadline = deadline_s
        self._told: Callable[[str], None] = lambda _: None
        self._ending: Callable[[], bool] = lambda: False
        self._hand = _Hand(deadline_s, lambda: robot.act(STILL))
        self._begun = self._stopped = False

    def meet(self, told: Callable[[str], None], ending: Callable[[], bool]) -> None:
        """Get to know whom to tell of a halt, and who says that the run shall end: a reading isn't waited for then."""
        self._told, self._ending = told, ending

    def sense(self) -> Reading | None:
        """Return the robot's next reading, None at the end of its run or when the run shall end."""
        patience = self._deadline if self._begun else max(self._deadline, FIRST_S)
        found = self._ask("sense()", self._robot.sense, patience)
        self._begun = True
        return found

    def act(self, command: Command) -> None:
        """Hand a command to the robot."""
        self._hand.armed = True
        if self._hand.halted:
            self._hand.halted = False
            self._told(f"a step took longer than {self._deadline:g} s: the wheels were halted until its command")
        self._ask("act()", lambda: self._robot.act(command), self._deadline)

    def stop(self) -> None:
        """Stop the wheels, once, even while another call hangs. Raises RobotFault when that hangs too."""
        if self._stopped:
            return
        self._stopped = True
        self._hand.armed = False
        done: Future[None] = Future()
        threading.Thread(target=_settle, args=(done, self._robot.stop), daemon=True).start()
        self._wait("stop()", done, self._deadline, ending=lambda: False)
        self._hand.dismiss()

    def _ask(self, name: str, call: Callable[[], T], seconds: float) -> T | None:
        return self._wait(name, self._hand.ask(call), seconds, self._ending)

    def _wait(self, name: str, answer: Future[T], seconds: float, ending: Callable[[], bool]) -> T | None:
        last, left = monotonic() + seconds, seconds
        while left > 0 and not _done(answer, min(left, SLICE_S)):
            if ending():
                last = min(last, monotonic() + GRACE_S)
                ending = lambda: False  # noqa: E731 the grace is counted once
            left = last - monotonic()
        if answer.done():
            return answer.result()
        if self._ending():
            return None
        raise RobotFault(f"the robot's {name} didn't return within {seconds:g} s: {self._halt(name)}")

    def _halt(self, name: str) -> str:
        if name == "stop()":
            return "its wheels may still turn"
        self.stop()
        return "its wheels were stopped"


class _Hand:
    """The thread that calls the robot, one call after the other; armed: commands are given, so that none for too long
    halts the wheels (halted: that happened)."""

    def __init__(self, deadline_s: float, halt: Callable[[], None]) -> None:
        self.armed = self.halted = False
        self._deadline, self._halt = min(deadline_s, threading.TIMEOUT_MAX), halt
        self._asked: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        # a daemon: a call that never returns doesn't keep the program from ending
        threading.Thread(target=self._work, daemon=True).start()

    def ask(self, call: Callable[[], T]) -> Future[T]:
        answer: Future[T] = Future()
        self._asked.put(lambda: _settle(answer, call))
        return answer

    def dismiss(self) -> None:
        self._asked.put(None)

    def _work(self) -> None:
        while True:
            try:
                call = self._asked.get(timeout=self._deadline)
            except Empty:
                if self.armed and not self.halted:
                    self.halted = True
                    _settle(Future(), self._halt)
                continue
            if call is None:
                return
            call()


def _settle(answer: Future[T], call: Callable[[], T]) -> None:
    try:
        answer.set_result(call())
    except BaseException as error:  # whatever it is, it is raised again where the answer is waited for
        answer.set_exception(error)


def _done(answer: Future[T], seconds: float) -> bool:
    try:
        answer.exception(timeout=seconds)
    except TimeoutError:
        return False
    return True
