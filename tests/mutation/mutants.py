"""Small mistakes made on purpose in a source file, one at a time."""

from __future__ import annotations

import ast
import copy
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One mistake: the file, the line, what it was and what it is, and the whole changed source.

    function: line where the outermost function or method begins that holds it (its first decorator); 0: none does.
    """

    file: str
    line: int
    was: str
    now: str
    source: str
    function: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.was} -> {self.now}"


def mutants(file: str) -> Iterator[Mutant]:
    """Yield every mutant of a source file; docstrings, types and texts stay."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf8"))
    places = [node for node in ast.walk(tree) if _changes(node)]
    hidden = _hidden(tree)
    for node in places:
        if id(node) in hidden:
            continue
        for change in _changes(node):
            before = copy.copy(node.__dict__)
            was = _short(node)
            now = change(node)
            line = getattr(node, "lineno", 0)
            text = ast.unparse(ast.fix_missing_locations(tree))
            yield Mutant(file, line, was, now, text, _function(tree, line))
            node.__dict__.clear()
            node.__dict__.update(before)


def _function(tree: ast.Module, line: int) -> int:
    """Return the first line, as code objects count it, of the function or method around a line; 0: there is none."""
    inside = [body for body in tree.body if isinstance(body, ast.ClassDef)]
    for node in [*tree.body, *(one for body in inside for one in body.body)]:
        if isinstance(node, ast.FunctionDef) and node.body[0].lineno <= line <= (node.end_lineno or 0):
            return min([node.lineno, *(one.lineno for one in node.decorator_list)])
    return 0


def _hidden(tree: ast.AST) -> set[int]:
    """Return what isn't executed as logic: annotations, decorators, and raising with its text."""
    roots: list[ast.AST | None] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            roots += [node.returns, *node.decorator_list]
            roots += [one.annotation for one in (*node.args.args, *node.args.kwonlyargs, *node.args.posonlyargs)]
        elif isinstance(node, ast.AnnAssign):
            roots.append(node.annotation)
        elif isinstance(node, ast.Raise | ast.JoinedStr | ast.ClassDef):
            roots += [node] if not isinstance(node, ast.ClassDef) else node.decorator_list
    return {id(inner) for root in roots if root is not None for inner in ast.walk(root)}


def _changes(node: ast.AST) -> list:
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
    node.value = (not node.value) if isinstance(node.value, bool) else node.value + 1
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
    every = [mutant for file in files if not file.endswith(("__init__.py", "_pb2.py")) for mutant in mutants(file)]
    return every if not sample or sample >= len(every) else random.Random(seed).sample(every, sample)


def _sources(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("*.py"))
