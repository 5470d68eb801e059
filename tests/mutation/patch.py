"""A mistake put into a process that has everything loaded: the changed function alone, or else all modules anew."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Iterator
from functools import cache, cached_property, partial
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

from mutation.mutants import ROOT, Mutant

COMPILED = ("topomap.vision.registry", "topomap.vision.image.seam", "sim2d.render.kernel")
"""Kernels that stay compiled where one of the map's is changed, which then all run as plain Python: numba's caches
don't notice that a callee has changed."""
COMPILED_HERE = "topomap/vision/"
"""Where no kernel calls one of another file, so that a changed one is compiled anew and tests are as quick as ever."""


def apply(mutant: Mutant, copied: Path) -> None:
    """Make the mistake in this process; the changed file is on disk already."""
    called = mutant.inside.split(".")[-1] in _called_on_import()
    if not mutant.kernel and mutant.inside and not called and _swapped(mutant, copied):
        return
    for name, module in list(sys.modules.items()):
        if (getattr(module, "__file__", None) or "").startswith(f"{copied}/"):
            del sys.modules[name]
    if mutant.kernel:
        _without_numba()


@cache
def _called_on_import() -> frozenset[str]:
    """Return the names of functions that are called while modules are loaded: what they made stays as it was."""
    files = [path for one in ("topomap", "logs") for path in sorted((ROOT / one).rglob("*.py"))]
    trees = [ast.parse(file.read_text(encoding="utf8")) for file in files]
    bodies = {node.name: node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    left: list[ast.AST] = [
        node for tree in trees for node in tree.body if not isinstance(node, ast.FunctionDef | ast.ClassDef)
    ]
    known: set[str] = set()
    while left:
        calls = (node for node in ast.walk(left.pop()) if isinstance(node, ast.Call))
        names = {node.func.id for node in calls if isinstance(node.func, ast.Name)}
        left += [bodies[name] for name in names - known if name in bodies]
        known |= names
    return frozenset(known)


def _without_numba() -> None:
    import numba

    for name in COMPILED:
        importlib.import_module(name)
    numba.config.DISABLE_JIT = True


def _swapped(mutant: Mutant, copied: Path) -> bool:
    """Give the one live function the changed code; False where it can't be found or holds other variables."""
    path = copied / mutant.file
    module = sys.modules.get(mutant.file.removesuffix(".py").replace("/", "."))
    if module is None:
        return False
    codes = [code for code in _codes(compile(mutant.source, str(path), "exec")) if code.co_qualname == mutant.inside]
    live = [one for one in _functions(module) if one.__code__.co_qualname == mutant.inside]
    live = list({id(one): one for one in live if one.__code__.co_filename == str(path)}.values())
    if len(codes) != 1 or len(live) != 1 or codes[0].co_freevars != live[0].__code__.co_freevars:
        return False
    live[0].__code__ = codes[0]
    return True


def _codes(code: CodeType) -> Iterator[CodeType]:
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield one
            yield from _codes(one)


def _functions(module: ModuleType) -> Iterator[FunctionType]:
    own = [one for one in vars(module).values() if isinstance(one, type) and one.__module__ == module.__name__]
    for holder in (module, *own):
        for value in list(vars(holder).values()):
            yield from _unwrapped(value)


def _unwrapped(value: object) -> Iterator[FunctionType]:
    if isinstance(value, FunctionType):
        yield value
    inner: list[object] = [getattr(value, "__wrapped__", None)] if callable(value) else []
    if isinstance(value, staticmethod | classmethod):
        inner.append(value.__func__)
    elif isinstance(value, property):
        inner += [value.fget, value.fset]
    elif isinstance(value, cached_property | partial):
        inner.append(value.func)
    for one in inner:
        if one is not None:
            yield from _unwrapped(one)
