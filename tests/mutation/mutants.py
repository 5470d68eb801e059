"""Small mistakes made on purpose in a source file, one at a time."""

from __future__ import annotations

import ast
import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
LARGE = 100
SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One mistake: the file, the line, what it was and what it is, and the whole changed source.

    inside: qualified name of the function or method whose body holds it, "" where none does; kernel: it is compiled.
    """

    file: str
    line: int
    was: str
    now: str
    source: str
    inside: str
    kernel: bool

    @property
    def name(self) -> str:
        """What it is, in words that stay when lines move."""
        return f"{self.inside}: {self.was} -> {self.now}"

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.name}"


def count(file: str) -> int:
    """Return how many mutants a source file has; docstrings, types and texts stay."""
    return len(_sites(ast.parse((ROOT / file).read_text(encoding="utf8"))))


def mutant(file: str, number: int) -> Mutant:
    """Return one of the mutants of a source file."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf8"))
    node, change = _sites(tree)[number]
    line, was = getattr(node, "lineno", 0), _short(node)
    inside, kernel = _bodies(tree).get(id(node), ("", False))
    now = change(node)
    return Mutant(file, line, was, now, ast.unparse(ast.fix_missing_locations(tree)), inside, kernel)


def _sites(tree: ast.Module) -> list[tuple[ast.AST, Callable[[Any], str]]]:
    """Return the nodes that can be changed, each with what changes it in place and says how."""
    hidden = _hidden(tree)
    return [(node, change) for node in ast.walk(tree) if id(node) not in hidden for change in _changes(node)]


def _bodies(tree: ast.Module) -> dict[int, tuple[str, bool]]:
    """Return for every node in the body of a function or method its qualified name, and whether numba compiles it."""
    found: dict[int, tuple[str, bool]] = {}
    for prefix, body in [
        ("", tree.body),
        *((f"{one.name}.", one.body) for one in tree.body if isinstance(one, ast.ClassDef)),
    ]:
        for node in body:
            if isinstance(node, ast.FunctionDef):
                kernel = any("njit" in ast.unparse(one) for one in node.decorator_list)
                inner = (id(inner) for statement in node.body for inner in ast.walk(statement))
                found |= dict.fromkeys(inner, (f"{prefix}{node.name}", kernel))
    return found


def _hidden(tree: ast.AST) -> set[int]:
    """Return what isn't executed as logic: annotations, decorators, and raising with its text."""
    roots: list[ast.AST | None] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            roots += [node.returns, *node.decorator_list]
            roots += [one.annotation for one in (*node.args.args, *node.args.kwonlyargs, *node.args.posonlyargs)]
        elif isinstance(node, ast.AnnAssign):
            roots.append(node.annotation)
        elif isinstance(node, ast.ClassDef):
            roots += node.decorator_list
        elif isinstance(node, ast.Raise | ast.JoinedStr) or _for_types_only(node):
            roots.append(node)
        elif isinstance(node, ast.keyword) and node.arg == "strict":
            roots.append(node)  # of zip: it checks what is never so
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
            roots += [one for one in node.args if ast.unparse(one) == "-1"]  # any negative number says the same
    return {id(inner) for root in roots if root is not None for inner in ast.walk(root)}


def _for_types_only(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def _changes(node: ast.AST) -> list[Callable[[Any], str]]:
    """Return what can be made of a node: functions that change it in place and say how."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in SWAPS:
        return [_swap_op]
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SWAPS:
        return [_swap_compare]
    if isinstance(node, ast.BoolOp):
        return [_swap_op]
    if isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
        return [_number]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        return [_without]
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        return [_never]
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        return [_left_out]
    if isinstance(node, ast.Return) and node.value is not None and not _is_none(node.value):
        return [_nothing]
    return []


def _swap_op(node) -> str:
    node.op = SWAPS[type(node.op)]()
    return _short(node)


def _swap_compare(node) -> str:
    node.ops = [SWAPS[type(node.ops[0])]()]
    return _short(node)


def _number(node) -> str:
    if isinstance(node.value, bool):
        node.value = not node.value
    else:  # one more is nothing beside a large number
        node.value = node.value + 1 if abs(node.value) < LARGE else 2 * node.value
    return _short(node)


def _without(node) -> str:
    node.op = ast.UAdd() if isinstance(node.op, ast.USub) else ast.Not()
    if isinstance(node.op, ast.Not):
        node.operand = ast.UnaryOp(ast.Not(), node.operand)
    return _short(node)


def _never(node) -> str:
    node.test = ast.Constant(False)
    return f"{_short(node)} (never)"


def _left_out(node) -> str:
    node.value = ast.Constant(None)
    return "left out"


def _nothing(node) -> str:
    node.value = ast.Constant(None)
    return "return None"


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _short(node: ast.AST) -> str:
    return " ".join(ast.unparse(node).split())[:70]


def chosen(folders: list[str], sample: int, seed: int) -> list[Mutant]:
    """Return the mutants of some folders, or a sample of so many."""
    files = [str(path.relative_to(ROOT)) for one in folders for path in _sources(ROOT / one)]
    files = [file for file in files if not file.endswith(("__init__.py", "_pb2.py"))]
    every = [(file, number) for file in files for number in range(count(file))]
    if sample and sample < len(every):
        every = random.Random(seed).sample(every, sample)
    return [mutant(*one) for one in every]


def _sources(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("*.py"))
