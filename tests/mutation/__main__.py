"""`python -m tests.mutation topomap/mapping --sample 60`: which small mistakes no test notices.

It works on a copy of the repository. mutmut and cosmic-ray start the whole suite once per mutant or need a database;
here each folder has the tests that answer for it, and of them those run that call the changed function.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
import tomllib
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "helpers")]

from mutation.mutants import ROOT, Mutant, chosen  # noqa: E402 the path comes first
from mutation.reach import Reach, importers  # noqa: E402
from mutation.trial import passes, prepare, reach  # noqa: E402

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
SLOWEST_S, TIMES = 60.0, 5.0
"""A mutant whose tests take so long, and so many times their time without it, never ends: that is noticed."""


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
    began = time.monotonic()
    known, named = reach(tests, copied), importers(copied, ("topomap", "logs"))
    seconds = time.monotonic() - began
    print(f"{folder}: {len(known.seconds) - len(known.failed)} tests pass in {seconds:.0f} s", flush=True)
    if known.failed:
        print(f"left out, as they fail without any mutant: {', '.join(sorted(known.failed))}", flush=True)
    reasons = tomllib.loads(EQUIVALENT.read_text(encoding="utf8")) if EQUIVALENT.exists() else {}
    alive, excused = [], {}
    for k, mutant in enumerate(every, 1):
        if not _survives(mutant, known, named, copied):
            continue
        reason = _reason(mutant, reasons)
        print(f"{k}/{len(every)} lives{f' ({reason})' if reason else ''}: {mutant}", flush=True)
        if reason:
            excused[str(mutant)] = reason
        else:
            alive.append(str(mutant))
    counted = len(every) - len(excused)
    killed = counted - len(alive)
    share = 100 * killed / max(counted, 1)
    print(f"{folder}: {killed} of {counted} killed ({share:.0f} %), {len(excused)} can't be noticed", flush=True)
    return {"mutants": len(every), "killed": killed, "share": share, "alive": alive, "equivalent": excused}


def _survives(mutant: Mutant, known: Reach, named: dict[str, set[str]], copied: Path) -> bool:
    tests = known.of(mutant, named)
    if not tests:
        return True
    target = copied / mutant.file
    original = target.read_bytes()
    usual = sum(known.seconds.get(test, 0.0) for test in tests)
    try:
        target.write_text(mutant.source, encoding="utf8")
        return passes(tests, SLOWEST_S + TIMES * usual)
    finally:
        target.write_bytes(original)


def _reason(mutant: Mutant, reasons: dict[str, dict[str, str]]) -> str:
    """Return why a mutant can't be noticed, "" where nobody says so; lines move, so the words name it."""
    return reasons.get(mutant.file, {}).get(f"{mutant.was} -> {mutant.now}", "")


if __name__ == "__main__":
    sys.exit(main())
