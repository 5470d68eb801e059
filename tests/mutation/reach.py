"""Which test files answer for a source file: those that import it, then those that import what imports it."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

from mutation.mutants import ROOT


def tiers(file: str, tests: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Return the test files that import a source file themselves or through a helper, and all others that reach it."""
    every = [str(path.relative_to(ROOT)) for one in tests for path in _files(ROOT / one)]
    direct = [test for test in every if file in _named(test)]
    return direct, [test for test in every if test not in direct and file in _reached(test)]


def _files(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("test_*.py"))


@cache
def _reached(file: str) -> frozenset[str]:
    """Return every source file that is loaded when a file is."""
    found, left = {file}, [file]
    while left:
        new = _imports(left.pop()) - found
        found |= new
        left += new
    return frozenset(found)


@cache
def _named(test: str) -> frozenset[str]:
    """Return what a test file imports, and what helpers that it imports do; a package stands for what it hands on."""
    found = set(_imports(test))
    for file in list(found):
        if file.startswith("tests/") or file.endswith("__init__.py"):
            found |= _imports(file)
    return frozenset(found)


@cache
def _imports(file: str) -> frozenset[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse((ROOT / file).read_text(encoding="utf8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= _located(node.module)
            for alias in node.names:
                found |= _located(f"{node.module}.{alias.name}")
        elif isinstance(node, ast.Import):
            for alias in node.names:
                found |= _located(alias.name)
    return frozenset(found)


def _located(module: str) -> set[str]:
    """Return the repository's file of a module, a helper's too; nothing for another's."""
    path = module.replace(".", "/")
    tried = (f"{path}.py", f"{path}/__init__.py", f"tests/helpers/{path}.py", f"tests/log_files/{path}.py")
    return {one for one in tried if (ROOT / one).is_file()}
