"""Methods as settings: a name of the registry, checked when it is read, or from Python an object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from topomap.core.errors import DataError
from topomap.vision import registry
from topomap.vision.aligned_homing import Method
from topomap.vision.contracts import Aligner


def found(find: Callable[..., object], *chosen: Any) -> None:  # Any: what a file or a user put there
    """Refuse as a wrong setting, in one line, what can't be found."""
    try:
        find(*chosen)
    except DataError as error:
        raise PydanticCustomError("method", "{reason}", {"reason": str(error)}) from error


def _checked(find: Callable[..., object]) -> PlainValidator:
    def check(chosen: Any) -> Any:
        found(find, chosen)
        return chosen

    return PlainValidator(check)


def _compass(chosen: str | Aligner) -> object:
    return None if chosen == registry.OWN else registry.aligner(chosen)


# an object is stored as Python prints it: the log tells what drove the robot, yet only Python can make it anew
_NAMED = PlainSerializer(lambda chosen: chosen if isinstance(chosen, str) else repr(chosen), return_type=str)
_TEXT = WithJsonSchema({"type": "string"})

AlignerChoice = Annotated[str | Aligner, _checked(registry.aligner), _NAMED, _TEXT]
CompassChoice = Annotated[str | Aligner, _checked(_compass), _NAMED, _TEXT]
HomingChoice = Annotated[str | Method | Aligner, _checked(registry.aligned_homing), _NAMED, _TEXT]
