"""Kernels kept on disk: none may run on once a text that it holds has changed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from sim2d.render import kernel, raycast
from sim2d.render import panorama as render

HERE = Path(kernel.__file__).parent


def test_every_file_with_a_kernel_is_watched() -> None:
    with_kernels = {path.stem for path in HERE.parent.rglob("*.py") if re.search(r"^@kernel", path.read_text(), re.M)}
    assert with_kernels <= set(kernel.SOURCES)
    assert not [path for path in HERE.parent.rglob("*.py") if path.stem != "kernel" and "njit" in path.read_text()]


def test_what_a_kernel_takes_constants_from_is_watched() -> None:
    """A global number is frozen into the code: its file must be watched as well."""
    for name in kernel.SOURCES:
        text = (HERE / f"{name}.py").read_text()
        for source, names in re.findall(r"^from sim2d\.(?:render\.)?(\w+) import \(?([^)\n]+)", text, re.M):
            if re.search(r"\b[A-Z]{3,}\b", names) and "@kernel" in text:
                assert source in kernel.SOURCES, (name, source)


def test_a_changed_text_changes_the_name_that_is_looked_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in kernel.SOURCES:
        (tmp_path / f"{name}.py").write_bytes((HERE / f"{name}.py").read_bytes())
    monkeypatch.setattr(kernel, "__file__", str(tmp_path / "kernel.py"))
    assert kernel.sources_digest() == kernel.DIGEST
    for name in kernel.SOURCES:
        before = kernel.sources_digest()
        with (tmp_path / f"{name}.py").open("a") as file:
            file.write("# edited\n")
        assert kernel.sources_digest() != before


def test_kept_kernels_carry_the_digest() -> None:
    for function in (render.render, raycast.cast, raycast.walk):
        assert kernel.DIGEST in function.py_func.__qualname__  # type: ignore[attr-defined]
        assert kernel.DIGEST in function._cache._impl._filename_base  # type: ignore[attr-defined]
