"""`make bench`: every bench_*.py beside this file gives rows; they are shown and written to bench.json."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent


def load(path: Path) -> ModuleType:
    """Return a bench file as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def main() -> None:
    """Run all benches, print a line a row, write bench.json in this folder's repository."""
    rows = []
    for path in sorted(HERE.glob("bench_*.py")):
        for row in load(path).rows():
            peer = f"  {row['ratio']:.1f} x {row['peer']} ({row['peer_ms']:.3f} ms)" if row.get("peer") else ""
            print(f"{row['name']:<44} {row['ms']:9.3f} ms  {row['size']}{peer}", flush=True)
            rows.append(row)
    (HERE.parents[1] / "bench.json").write_text(json.dumps(rows, indent=1) + "\n")


main()
