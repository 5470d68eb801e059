"""Methods by name, as the settings and the tables have them, and the arenas that they are tried in."""

from __future__ import annotations

import numpy as np
import pytest
from kept import as_before
from pydantic import BaseModel, ValidationError
from scenes import view

from topomap.core.errors import DataError
from topomap.core.geometry import TAU, Pose2
from topomap.vision.arena import KEPT, Arena, Recipe
from topomap.vision.choice import AlignerChoice, CompassChoice, HomingChoice
from topomap.vision.compass import ALIGNERS
from topomap.vision.image.compare import Signature, sector_means, signature, turned
from topomap.vision.registry import defaults, entries


class Chosen(BaseModel, arbitrary_types_allowed=True):
    aligner: AlignerChoice = "min-warping"
    compass: CompassChoice = "own"
    homing: HomingChoice = "dtw-unifying"


def test_the_tables_entries_are_as_before() -> None:
    as_before("registry", {
        f"{one.kind} {one.name}": [one.row, one.family, one.needs, str(one.homes), one.source, one.defaults]
        for one in entries()
    })  # fmt: skip


def test_parameters_are_told_where_they_are_plain() -> None:
    assert defaults(object()) == ""
    assert defaults(ALIGNERS["visual-compass"]).startswith("form=ssd window=0.7854")


@pytest.mark.parametrize("field", ["aligner", "compass", "homing"])
def test_a_setting_takes_a_name_that_is_known(field: str) -> None:
    assert getattr(Chosen(**{field: "min-warping"}), field) == "min-warping"
    with pytest.raises(ValidationError, match="telepathy") as told:
        Chosen(**{field: "telepathy"})
    assert told.value.errors()[0]["type"] == "method"


def test_a_setting_takes_an_object_and_is_stored_as_it_is_written() -> None:
    given = ALIGNERS["min-warping"]
    stored = Chosen(aligner=given, compass=given).model_dump()
    assert stored == {"aligner": repr(given), "compass": repr(given), "homing": "dtw-unifying"}
    assert Chosen.model_json_schema()["properties"]["aligner"]["type"] == "string"


def arena(name: str = "made", seed: int = 0, options: tuple[str, ...] = ()) -> Arena:
    positions = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    return Arena(f"{name} {seed}", None, positions, 1.0, False, (0.0, 0.0))  # type: ignore[arg-type]


def test_the_nearest_position_is_found_within_three_quarters_of_the_spacing() -> None:
    made = arena()
    assert made.index((1.2, 1.4)) == 2
    assert made.at(2) == (1.0, 2.0)
    assert made.index((1.75, 0.0)) == 1
    with pytest.raises(DataError, match=r"made 0 has no free grid position at 1.8,0; .* 0.00,0.00 to 1.00,2.00 m"):
        made.index((1.8, 0.0))


def test_few_arenas_are_kept_the_newest() -> None:
    recipes = [Recipe("kept", seed, arena) for seed in range(KEPT + 1)]
    made = [recipe.arena() for recipe in recipes]
    assert made[-1].name == f"kept {KEPT}"
    assert recipes[1].arena() is made[1]
    assert recipes[0].arena() is not made[0]


def test_a_small_view_is_turned_to_any_fraction_of_a_column() -> None:
    small = signature(view(Pose2(3.7, 2.8, 0.4)))
    column = TAU / small.pixels.shape[1]
    found = turned(small, np.array([0.0, column, -3 * column, 0.5 * column]))
    for k, columns in ((0, 0), (1, 1), (2, -3)):
        assert found[k] == pytest.approx(np.roll(small.pixels, columns, axis=1), abs=1e-4)
    twice = turned(Signature(found[3], np.fft.rfft(found[3], axis=1)), np.array([0.5 * column]))[0]
    assert np.abs(twice - found[1]).mean() < 0.02


def test_means_over_sectors_hold_all_columns() -> None:
    assert sector_means(np.array([[1.0, 3.0, 5.0, 7.0, 9.0]]), 2).tolist() == [[2.0, 7.0]]
