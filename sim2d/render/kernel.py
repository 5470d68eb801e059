"""The compiler of the ray and pixel kernels: what numba keeps on disk isn't run once any kernel's text has changed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., object])

SOURCES = ("kernel", "canvas", "atlas", "scene", "raycast", "texel", "column", "panorama", "lights")


def sources_digest() -> str:
    """Return a short digest of all files whose kernels inline each other or whose constants they freeze."""
    here = Path(__file__).parent
    return hashlib.sha256(b"\0".join((here / f"{name}.py").read_bytes() for name in SOURCES)).hexdigest()[:12]


DIGEST = sources_digest()


def kernel(function: F) -> F:
    """Compile a function, kept on disk under a name that holds the digest of all kernel sources.

    numba watches a function's own file only, so a caller kept on disk would go on running an edited callee's old code.
    """
    function.__qualname__ = f"{function.__qualname__}_{DIGEST}"
    compiled: F = njit(cache=True, error_model="numpy", forceinline=True)(function)
    return compiled
