"""Settings that make no sense: every one in turn as NaN, without end, huge, of another kind."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from sim2d import worlds
from sim2d.errors import WorldError
from sim2d.robot import SimRobot
from topomap.app.config import RunConfig, load_config
from topomap.app.wiring import build_navigator
from topomap.core.errors import TopomapError

VALUES = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-300", "-1", "0", f"1{'0' * 400}", "'[/x]\\u001b'", "[]",
          "{}", "true", "[[1]]")  # fmt: skip
TABLES = (
    "sim.kidnaps=[{at_s = 1, x = nan, y = 0}]",
    "sim.kidnaps=[{at_s = 1, x = 1e300, y = 0}]",
    "sim.kidnaps=[{at_s = 1, place = '../[/x]'}]",
    "sim.kidnaps=[{at_s = 1, x = 0, y = 0, colour = 3}]",
    "sim.camera.light_changes=[{hour = 3, at_s = 1, at_hour = 2}]",
    "sim.camera.light_changes=[{}]",
    "sim.camera.light_changes=3",
    "stack.mapper=7",
    "stack=[]",
    "sim.camera.width.height=3",
    "nonsense=1",
    "sim.driver.route='nowhere'",
    f"sim.camera.light_changes={'[' * 2000}{']' * 2000}",
    "=",
    "sim.",
    ".=1",
)


def words() -> Iterator[str]:
    """Yield `section.key=value` for every setting and senseless value."""
    yield from TABLES
    for path in _paths(RunConfig):
        for value in VALUES:
            yield f"{path}={value}"


def _paths(model: type[BaseModel], path: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        kind: Any = field.annotation
        own = f"{path}.{name}".lstrip(".")
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _paths(kind, own)
        else:
            yield own


def wrong_with(word: str, world: str) -> str | None:
    """Return what is wrong with how a setting is answered: None where it is one line, or it drives three steps."""
    try:
        config = load_config(None, [word])
        robot = SimRobot(worlds.load(world), config.sim, 0)
        navigator = build_navigator(config.stack)
        for _ in range(3):
            reading = robot.sense()
            assert reading is not None
            robot.act(navigator.step(reading)[0])
    except (TopomapError, WorldError) as error:
        return f"{word}: more than a line: {error!r}" if "\n" in str(error) or len(str(error)) > 2000 else None
    except Exception as error:
        return f"{word[:200]}: {type(error).__name__}: {error}"
    return None
