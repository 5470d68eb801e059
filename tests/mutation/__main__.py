"""`python -m tests.mutation topomap/mapping --sample 60`: which small mistakes no test notices.

It works on a copy of the repository. mutmut and cosmic-ray start the whole suite once per mutant or need a database;
here those tests of a folder run that import the changed file, and the others that reach it where these pass.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "helpers")]

from mutation.mutants import ROOT, Mutant, chosen  # noqa: E402 the path comes first
from mutation.reach import tiers  # noqa: E402
from mutation.trial import passes, prepare  # noqa: E402

TESTS: dict[str, tuple[str, ...]] = {
    "logs": ("tests/log_files", "tests/recording"),
    "topomap/recording": ("tests/recording", "tests/cli/test_closures_log.py"),
    "topomap/app/export.py": ("tests/app/test_export.py",),
    "topomap/mapping": ("tests/mapping", "tests/test_one_engine.py"),
    "topomap/navigation": ("tests/navigation", "tests/app/test_faults.py"),
}
"""Which tests answer for which folder."""
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
"""Mutants that no test can notice, each with the reason."""
SLOWEST_S = 600.0
"""A mutant whose tests take so long never ends: that is noticed."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", default=list(TESTS))
    parser.add_argument("--sample", type=int, default=60, help="so many mutants of each folder, 0: every one")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("mutation.json"))
    asked = parser.parse_args()
    out = asked.out.absolute()
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        copied = Path(folder).resolve() / "copy"
        shutil.copytree(ROOT, copied, ignore=shutil.ignore_patterns(".git", ".venv*", "runs", ".mypy_cache"))
        prepare(copied)
        for one in asked.folders:
            figures[one] = _tried(one, chosen([one], asked.sample, asked.seed), copied)
            out.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf8")
    return 0


def _tried(folder: str, every: list[Mutant], copied: Path) -> dict[str, object]:
    tests = next(tests for name, tests in TESTS.items() if folder.startswith(name))
    reasons = tomllib.loads(EQUIVALENT.read_text(encoding="utf8")) if EQUIVALENT.exists() else {}
    alive: list[str] = []
    excused: dict[str, str] = {}
    for k, mutant in enumerate(every, 1):
        if not _survives(mutant, tests, copied):
            continue
        reason = reasons.get(mutant.file, {}).get(mutant.name, "")
        print(f"{k}/{len(every)} lives{f' ({reason})' if reason else ''}: {mutant}", flush=True)
        if reason:
            excused[str(mutant)] = reason
        else:
            alive.append(str(mutant))
    killed = len(every) - len(excused) - len(alive)
    share = 100 * killed / max(len(every) - len(excused), 1)
    print(f"{folder}: {killed} of {len(every)} killed, {len(excused)} can't be noticed: {share:.0f} %", flush=True)
    return {"mutants": len(every), "killed": killed, "share": share, "alive": alive, "equivalent": excused}


def _survives(mutant: Mutant, tests: tuple[str, ...], copied: Path) -> bool:
    """Return whether a mutant passes the tests that name its file, and then all others that reach it."""
    target = copied / mutant.file
    original = target.read_bytes()
    try:
        target.write_text(mutant.source, encoding="utf8")
        return all(passes(tier, SLOWEST_S) for tier in tiers(mutant.file, tests) if tier)
    finally:
        target.write_bytes(original)


if __name__ == "__main__":
    sys.exit(main())
