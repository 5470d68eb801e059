"""Nothing is left to be compiled once a robot moves."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

DEN = Path(__file__).parents[1] / "helpers" / "den.toml"
SCRIPT = """
import sys
from numba.core.dispatcher import Dispatcher
from sim2d import worlds
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig
from topomap.app.warm_up import warm_up
from topomap.app.wiring import build_navigator

def compiled():
    # name and types of every kernel of the stack in memory
    found = set()
    for name, module in list(sys.modules.items()):
        if name.startswith("topomap."):
            for key, value in vars(module).items():
                if isinstance(value, Dispatcher):
                    found |= {(value.py_func.__qualname__, str(types)) for types in value.signatures}
    return found

warm_up()
before = compiled()
config = RunConfig()
robot = SimRobot(worlds.load(sys.argv[1]), config.sim, 0)
navigator = build_navigator(config.stack)
for _ in range(150):
    reading = robot.sense()
    command, record = navigator.step(reading)
    robot.act(command)
assert len(navigator.mapper.map.closures) > 0, "too short a drive to tell"
assert len(before) > 10, before
print(sorted(compiled() - before))
"""


def test_no_step_waits_for_a_kernel_to_be_compiled() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT, str(DEN)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
