"""The rows of a g2o or TORO file as arrays; every error names file and line."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.core.errors import DataError
from topomap.core.files import regular

# where row and column of the information matrix stand among an edge's six last numbers
UPPER = {"EDGE_SE2": ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
         "EDGE2": ((0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2))}  # fmt: skip
# ids and numbers of a row
WIDTHS = {"EDGE_SE2": (2, 9), "EDGE2": (2, 9), "VERTEX_SE2": (1, 3), "VERTEX2": (1, 3)}
IGNORED = ("EQUIV", "FIX", "PARAMS")
SPACE = ("EDGE_SE3", "VERTEX_SE3", "EDGE3", "VERTEX3")  # how the rows of graphs in space begin


class Edges(NamedTuple):
    """E edges in the order of the file: line (E,), ends (E, 2) as ids, relative (E, 3), information (E, 3, 3)."""

    line: IntArray
    ends: IntArray
    relative: FloatArray
    information: FloatArray


class Vertices(NamedTuple):
    """V poses that a file states: ids (V,), poses (V, 3)."""

    ids: IntArray
    poses: FloatArray


class _Kind(NamedTuple):
    """The rows of one kind: their lines (n,), ids (n, .), numbers (n, .)."""

    line: IntArray
    ids: IntArray
    numbers: FloatArray


def read_rows(path: Path) -> tuple[Edges, Vertices]:
    """Return a file's edges and vertices. Raises DataError."""
    kinds = {kind: _parsed(path, kind, *rows) for kind, rows in _texts(path).items()}
    edges = [_edges(kind, rows) for kind, rows in kinds.items() if kind in UPPER]
    if not edges:
        raise DataError(f"{path}: no edge 'EDGE_SE2' or 'EDGE2'")
    vertices = [rows for kind, rows in kinds.items() if kind not in UPPER]
    ids = np.concatenate([np.zeros(0, np.int64), *(rows.ids[:, 0] for rows in vertices)])
    poses = np.concatenate([np.zeros((0, 3)), *(rows.numbers for rows in vertices)])
    return _in_order(edges), Vertices(ids, poses)


def _in_order(parts: list[Edges]) -> Edges:
    """Return edges of several kinds in the order of the file."""
    line = np.concatenate([part.line for part in parts])
    order = np.argsort(line)
    return Edges(
        line[order],
        np.concatenate([part.ends for part in parts])[order],
        np.concatenate([part.relative for part in parts])[order],
        np.concatenate([part.information for part in parts])[order],
    )


def _texts(path: Path) -> dict[str, tuple[list[int], list[str]]]:
    """Return line numbers and what follows the first word, by the first word."""
    try:
        lines = regular(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: can't be read: {error}") from error
    texts: dict[str, tuple[list[int], list[str]]] = {}
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split(None, 1)
        if not words or words[0].startswith(IGNORED):
            continue
        if words[0] not in WIDTHS:
            raise DataError(f"{path}:{number}: {_unknown(words[0])}")
        numbers, rest = texts.setdefault(words[0], ([], []))
        numbers.append(number)
        rest.append(words[1] if len(words) > 1 else "")
    return texts


def _unknown(kind: str) -> str:
    if kind.startswith(SPACE):
        return f"row '{kind}' is of a graph in space; only graphs in the plane are read ({', '.join(UPPER)})"
    return f"row '{kind}' is none of {', '.join((*WIDTHS, *IGNORED))}"


def _parsed(path: Path, kind: str, lines: list[int], rest: list[str]) -> _Kind:
    ids, numbers = WIDTHS[kind]
    row = np.dtype([("ids", np.int64, (ids,)), ("numbers", np.float64, (numbers,))])
    try:
        if "" in rest:  # an empty row is none to loadtxt
            raise ValueError("a row is empty")
        table = np.loadtxt(rest, dtype=row, comments=None, ndmin=1)
    except (ValueError, OverflowError) as error:
        raise DataError(_first_fault(path, kind, lines, rest) or f"{path}: '{kind}': {error}") from None
    if not np.isfinite(table["numbers"]).all():
        raise DataError(_first_fault(path, kind, lines, rest) or f"{path}: '{kind}' holds a number that isn't finite")
    return _Kind(np.array(lines), table["ids"], table["numbers"])


def _first_fault(path: Path, kind: str, lines: list[int], rest: list[str]) -> str | None:
    """Return what is wrong with the first wrong row."""
    ids, numbers = WIDTHS[kind]
    for line, text in zip(lines, rest, strict=True):
        words = text.split()
        if len(words) != ids + numbers:
            return f"{path}:{line}: '{kind}' needs {ids + numbers} numbers, it has {len(words)}"
        for place, word in enumerate(words):
            if not (_is_id(word) if place < ids else _is_number(word)):
                belongs = "a pose's id" if place < ids else "a finite number"
                return f"{path}:{line}: '{kind}' holds '{word}' where {belongs} belongs"
    return None


def _is_id(word: str) -> bool:
    try:
        return abs(int(word)) < 2**63
    except ValueError:
        return False


def _is_number(word: str) -> bool:
    try:
        return bool(np.isfinite(float(word)))
    except ValueError:
        return False


def _edges(kind: str, rows: _Kind) -> Edges:
    information = _matrices(kind, rows.numbers[:, 3:])
    if kind == "EDGE2" and not positive_definite(information).all():
        # w20000 and others of gtsam's examples say EDGE2 and mean g2o's order, which TORO's can't be mistaken for
        other = _matrices("EDGE_SE2", rows.numbers[:, 3:])
        information = other if positive_definite(other).all() else information
    return Edges(rows.line, rows.ids, rows.numbers[:, :3], information)


def _matrices(kind: str, numbers: FloatArray) -> FloatArray:
    """Return symmetric matrices (n, 3, 3) of numbers (n, 6) in the order of a kind of row."""
    matrices = np.zeros((len(numbers), 3, 3))
    for (row, column), values in zip(UPPER[kind], numbers.T, strict=True):
        matrices[:, row, column] = matrices[:, column, row] = values
    return matrices


def positive_definite(matrices: FloatArray) -> BoolArray:
    """Return (n,) which of symmetric matrices (n, 3, 3) are positive definite."""
    return np.asarray(np.linalg.eigvalsh(matrices)[:, 0] > 0.0)
