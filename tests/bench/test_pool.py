"""What a kept result rests on: a change in any of those files makes it void."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

import pytest

import sim2d
import topomap
from topomap.app.views import WORLD_FILES
from topomap.bench.pool import DECIDING, digest_files

ROOT = Path(topomap.__file__).parent
KEPT = ("bench/homing", "bench/places.py", "experiments")
"""Where the tasks are whose results are kept from one call to the next."""
WRITING = ("report", "evaluation/rows.py", "evaluation/summary.py")
"""What only draws or writes down results that were kept."""


@pytest.mark.parametrize("pattern", DECIDING)
def test_every_pattern_matches_files(pattern: str) -> None:
    assert list(ROOT.glob(pattern))


def test_all_that_the_tasks_import_is_part_of_the_key() -> None:
    rest = sorted(imported() - files(ROOT, DECIDING))
    assert [name for name in rest if not name.startswith(WRITING)] == []


def test_a_change_in_any_deciding_file_voids_what_was_kept(tmp_path: Path) -> None:
    copy = tmp_path / "topomap"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns("__pycache__"))
    names = files(ROOT, DECIDING)
    assert any(name.startswith("experiments/") for name in names)
    assert unnoticed(copy, DECIDING, names) == []


def test_a_change_in_the_simulator_or_a_world_file_voids_its_views(tmp_path: Path) -> None:
    copy = tmp_path / "sim2d"
    shutil.copytree(Path(sim2d.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    names = {str(path.relative_to(copy)) for path in copy.rglob("*.*") if path.suffix in (".py", ".toml")}
    assert "worlds/ourlab.toml" in names
    assert unnoticed(copy, WORLD_FILES, names) == []


def unnoticed(root: Path, patterns: tuple[str, ...], names: set[str]) -> list[str]:
    """The files whose change leaves the digest as it was."""
    before, found = digest_files(root, patterns), []
    for name in sorted(names):
        content = (root / name).read_bytes()
        (root / name).write_bytes(content + b"\n")
        if digest_files(root, patterns) == before:
            found.append(name)
        (root / name).write_bytes(content)
    return found


def files(root: Path, patterns: tuple[str, ...]) -> set[str]:
    return {str(path.relative_to(root)) for pattern in patterns for path in root.glob(pattern)}


def imported() -> set[str]:
    """All files of the package that the tasks' files import, at any depth."""
    waiting = [
        path for name in KEPT for path in ([ROOT / name] if name.endswith(".py") else (ROOT / name).rglob("*.py"))
    ]
    seen: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path not in seen:
            seen.add(path)
            if not str(path.relative_to(ROOT)).startswith(WRITING):
                waiting += imports(path)
    return {str(path.relative_to(ROOT)) for path in seen}


def imports(path: Path) -> list[Path]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("topomap."):
            base = ROOT.joinpath(*node.module.split(".")[1:])
            found += [base.with_suffix(".py"), base / "__init__.py", *(base / f"{n.name}.py" for n in node.names)]
    return [one for one in found if one.is_file()]
