"""`python -m tests.mutation topomap/mapping --sample 60`: which small mistakes no test notices.

It works on a copy of the repository. mutmut and cosmic-ray start the whole suite once per mutant or need a database;
here coverage tells once which tests run a line, and those alone are run, the quickest first, in a forked copy of one
process. A mutant whose tests don't notice it in BUDGET_S counts as one that lives, so the shares are rather too low.
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

from mutation import cover  # noqa: E402 the path comes first
from mutation.mutants import ROOT, Mutant, chosen  # noqa: E402
from mutation.named import named  # noqa: E402
from mutation.patch import COMPILED_HERE, apply  # noqa: E402
from mutation.reach import Reach  # noqa: E402
from mutation.trial import forked, load, noticed, prepare  # noqa: E402

FOLDERS = ("logs", "topomap/recording", "topomap/navigation", "topomap/mapping")
TESTS = ("tests/mapping", "tests/navigation", "tests/log_files", "tests/recording", "tests/old_files",
         "tests/app/test_faults.py", "tests/app/test_export.py", "tests/app/test_optimize.py",
         "tests/app/test_saved_maps.py", "tests/cli/test_closures_log.py", "tests/test_one_engine.py",
         "tests/test_constants.py")  # fmt: skip
"""The tests that answer for these folders."""
OWN = {"topomap/vision": ("tests/vision", "tests/test_constants.py")}
"""The tests that answer for another folder."""
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
"""Mutants that no test can notice, each with the reason."""
BUDGET_S = 20.0
"""CPU time of tests that a mutant is tried with, as measured beside coverage, which takes half of it: the figures of a
whole drive are kept by tests of 10 to 20."""
KERNEL_S = 3.0
"""A test that takes longer where kernels run as plain Python says nothing."""
COMPILING_S = 30.0
"""[s] What compiling one file's changed kernels takes at most, on a busy machine; 1 to 8 were measured."""
HOUR_S = 3600.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", default=list(FOLDERS))
    parser.add_argument("--sample", type=int, default=60, help="so many mutants of each folder, 0: every one")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("mutation.json"))
    parser.add_argument("--cover", type=Path, help="file of what the tests cover; measured where there is none")
    parser.add_argument("--named", action="store_true", help="only those of named.toml, by the tests named there")
    asked = parser.parse_args()
    out = asked.out.absolute()
    tests = tuple(dict.fromkeys(test for folder in asked.folders for test in OWN.get(folder, TESTS)))
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        copied = Path(folder).resolve() / "copy"
        known = (asked.cover or Path(folder) / "cover.json").absolute()
        shutil.copytree(ROOT, copied, ignore=shutil.ignore_patterns(".git", ".venv*", "runs", ".mypy_cache"))
        prepare(copied)
        if asked.named:
            return _named(copied)
        if not known.exists() and forked(lambda: cover.measure(copied, tests, known), HOUR_S):
            known.unlink(missing_ok=True)
            print("tests fail as they are: what they notice would tell nothing", file=sys.stderr)
            return 1
        found = cover.read(known)
        load(copied, tests)
        for one in asked.folders:
            figures[one] = _tried(one, chosen([one], asked.sample, asked.seed), copied, Reach(found))
            out.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf8")
    return 0


def _named(copied: Path) -> int:
    """Try every mistake of named.toml; 1 where one lives."""
    alive = 0
    for one in named():
        lives = not _failing(one.mutant(), [one.test], copied, HOUR_S)
        alive += lives
        print(f"{'lives' if lives else 'noticed'}: {one.what} ({one.test})", flush=True)
    return int(alive > 0)


def _tried(folder: str, every: list[Mutant], copied: Path, reach: Reach) -> dict[str, object]:
    reasons = tomllib.loads(EQUIVALENT.read_text(encoding="utf8")) if EQUIVALENT.exists() else {}
    alive: list[str] = []
    excused: dict[str, str] = {}
    for k, mutant in enumerate(every, 1):
        if reason := reasons.get(mutant.file, {}).get(mutant.name, ""):
            excused[str(mutant)] = reason
        elif survives(mutant, copied, reach):
            alive.append(str(mutant))
            print(f"{k}/{len(every)} lives: {mutant}", flush=True)
    tried = len(every) - len(excused)
    killed = tried - len(alive)
    low, high = wilson(killed, tried)
    print(
        f"{folder}: {killed} of {tried} killed: {100 * killed / max(tried, 1):.0f} % (95 %: {low:.0f}-{high:.0f}),"
        f" {len(excused)} more can't be noticed",
        flush=True,
    )
    return {"mutants": tried, "killed": killed, "low": low, "high": high, "alive": alive, "equivalent": excused}


def survives(mutant: Mutant, copied: Path, reach: Reach) -> bool:
    """Return whether a mutant passes all tests that run its line, and those beside them, as far as the budget goes."""
    tests, seconds = reach.tests(mutant, BUDGET_S)
    plain = mutant.kernel and not mutant.file.startswith(COMPILED_HERE)
    each = KERNEL_S if plain else None
    limit = 300.0 if plain else 30 + 4 * seconds + COMPILING_S * mutant.kernel
    failing = _failing(mutant, tests, copied, limit, each) if tests else ""
    reach.learn(failing)
    return not failing


def _failing(mutant: Mutant, tests: list[str], copied: Path, limit: float, each: float | None = None) -> str:
    target = copied / mutant.file
    original = target.read_bytes()
    try:
        target.write_text(mutant.source, encoding="utf8")
        return noticed(tests, lambda: apply(mutant, copied), limit, each)
    finally:
        target.write_bytes(original)


def wilson(count: int, of: int) -> tuple[float, float]:
    """Return the 95 % Wilson interval of a share [%]."""
    from topomap.evaluation.statistics import share_interval

    found = share_interval(count, of)
    return 100 * found.low, 100 * found.high


if __name__ == "__main__":
    sys.exit(main())
