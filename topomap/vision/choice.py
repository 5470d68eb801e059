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


def _checked(find: Callable[[Any], object]) -> PlainValidator:  # Any: what a file or a user put there
    """Keep what can be found; else say in one line what there is."""

    def check(chosen: Any) -> Any:
        try:
            find(chosen)
        except DataError as error:
            raise PydanticCustomError("method", "{reason}", {"reason": str(error)}) from error
        return chosen

    return PlainValidator(check)


# an object is stored as Python prints it: a log tells what drove the robot, yet only Python can make it anew
_NAMED = PlainSerializer(lambda chosen: chosen if isinstance(chosen, str) else repr(chosen), return_type=str)
_TEXT = WithJsonSchema({"type": "string"})

AlignerChoice = Annotated[str | Aligner, _checked(registry.aligner), _NAMED, _TEXT]
HomingChoice = Annotated[str | Method | Aligner, _checked(registry.aligned_homing), _NAMED, _TEXT]
CompassChoice = Annotated[
    str | Aligner, _checked(lambda chosen: chosen == registry.OWN or registry.aligner(chosen)), _NAMED, _TEXT
]
