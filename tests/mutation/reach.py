"""Which tests a mutant is tried with: those that run its line, the quickest first, then the others of their files.

A test that has noticed others comes earlier: what it asks is sharp.
"""

from __future__ import annotations

import ast
from collections import Counter
from functools import cache

from mutation.cover import Cover
from mutation.mutants import ROOT, Mutant

PACKAGES = ("topomap/mapping", "topomap/navigation", "topomap/recording", "topomap/app", "topomap/vision", "logs")
"""Where kernels and constants are used."""
Place = tuple[str, range]
CONSTANTS = "tests/test_constants.py"
"""Answers for what stands outside all functions."""
SHARP = 8
"""For each mutant that a test has noticed it may take so many times as long as others and comes before them."""


class Reach:
    """What the tests cover, asked mutant by mutant."""

    def __init__(self, cover: Cover) -> None:
        self._cover = cover
        self._noticed = Counter[str]()

    def learn(self, test: str) -> None:
        """Take which test noticed a mutant."""
        self._noticed[test] += 1

    def tests(self, mutant: Mutant, budget: float) -> tuple[list[str], float]:
        """Return the tests, quickest first, that take no longer than a budget [s] together, and how long they take."""
        running = self._running(mutant)
        files = {test.split("::")[0] for test in running}
        beside = {test for test in self._cover.seconds if test.split("::")[0] in files} - running
        chosen, seconds = list[str](), 0.0
        for test in [*self._order(running), *self._order(beside)]:
            if chosen and seconds + self._cover.seconds[test] > budget:
                continue
            chosen.append(test)
            seconds += self._cover.seconds[test]
        return chosen, seconds

    def _order(self, tests: set[str]) -> list[str]:
        return sorted(tests, key=lambda test: (self._cover.seconds[test] / (1 + SHARP * self._noticed[test]), test))

    def _running(self, mutant: Mutant) -> set[str]:
        if mutant.kernel:
            places = _callers(mutant.inside.split(".")[-1])
        elif mutant.inside:
            places = ((mutant.file, _statement(mutant)),)
        else:
            places = _resting(mutant)
        running = {test for file, lines in places for test in self._cover.running(file, lines)}
        naming = _naming(mutant.inside.split(".")[-1]) if mutant.kernel else frozenset()
        naming |= frozenset() if mutant.inside else {CONSTANTS}
        return running | {test for test in self._cover.seconds if test.split("::")[0] in naming}


def _statement(mutant: Mutant) -> range:
    """Return the lines of the statement that a mutant is in, without the block that it opens."""
    inner = [node for node in ast.walk(_tree(mutant.file)) if isinstance(node, ast.stmt) and _holds(node, mutant.line)]
    last = min(inner, key=lambda node: (node.end_lineno or 0) - node.lineno)
    return range(last.lineno, max(mutant.line, _head(last)) + 1)


def _resting(mutant: Mutant) -> tuple[Place, ...]:
    """Return what rests on a mutant outside all bodies: functions with its name, or those of its class or file."""
    whole = (mutant.file, range(1, 10**6))
    for node in _tree(mutant.file).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and _holds(node, mutant.line):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            return tuple(p for one in targets if isinstance(one, ast.Name) for p in _callers(one.id)) or (whole,)
        if isinstance(node, ast.FunctionDef) and _holds(node, mutant.line):
            return ((mutant.file, range(node.lineno, (node.end_lineno or 0) + 1)),)
    return (whole,)


def _head(node: ast.stmt) -> int:
    """Return the last line of a statement without the block that it opens."""
    body = getattr(node, "body", None)
    return body[0].lineno - 1 if body else node.end_lineno or node.lineno


def _holds(node: ast.stmt, line: int) -> bool:
    return node.lineno <= line <= (node.end_lineno or 0)


@cache
def _tree(file: str) -> ast.Module:
    return ast.parse((ROOT / file).read_text(encoding="utf8"))


@cache
def _callers(kernel: str) -> tuple[Place, ...]:
    """Return the functions that use a kernel or constant, those that use it in place of kernels that do."""
    found: list[Place] = []
    left, known = [kernel], {kernel}
    while left:
        for file, inner, compiled in _users(left.pop()):
            if not compiled:
                found.append((file, range(inner.body[0].lineno, (inner.end_lineno or 0) + 1)))
            elif inner.name not in known:
                known.add(inner.name)
                left.append(inner.name)
    return tuple(found)


@cache
def _naming(name: str) -> frozenset[str]:
    """Return the test files that import a name."""
    files = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").rglob("test_*.py"))]
    imports = ((file, node) for file in files for node in _tree(file).body if isinstance(node, ast.ImportFrom))
    return frozenset(file for file, node in imports if name in [alias.name for alias in node.names])


@cache
def _users(name: str) -> tuple[tuple[str, ast.FunctionDef, bool], ...]:
    """Return file, function and whether numba compiles it, for every function in which a name stands."""
    found: list[tuple[str, ast.FunctionDef, bool]] = []
    for file in (str(path.relative_to(ROOT)) for one in PACKAGES for path in sorted((ROOT / one).rglob("*.py"))):
        for node in ast.walk(_tree(file)):
            if isinstance(node, ast.FunctionDef) and node.name != name and _names(node, name):
                found.append((file, node, any("njit" in ast.unparse(one) for one in node.decorator_list)))
    return tuple(found)


def _names(node: ast.FunctionDef, name: str) -> bool:
    """Return whether a name stands in a function, by itself or as that of a module of kernels."""
    return any(_is_name(inner, name) for inner in ast.walk(node))


def _is_name(node: ast.AST, name: str) -> bool:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.attr == name and node.value.id.endswith("kernels")
    return isinstance(node, ast.Name) and node.id == name
