"""All of it: `python -m tests.fuzz` writes a line a failure and ends with code 1 if there is one."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "helpers")]

from fuzz.crafted import crafted  # noqa: E402 the path comes first
from fuzz.damage import COMMANDS, Answer, ask, cuts, flips, unsaid  # noqa: E402
from fuzz.settings import words, wrong_with  # noqa: E402
from fuzz.small_log import small_log  # noqa: E402

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flips", type=int, default=200)
    parser.add_argument("--cuts", type=int, default=50)
    parser.add_argument("--every", type=int, default=1, help="only every so-manieth crafted log and setting")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wrong = [*_damaged(Path(folder), asked.flips, asked.cuts), *_crafted(Path(folder), asked.every)]
    tried = list(words())[:: asked.every]
    wrong += [line for word in tried if (line := wrong_with(word, DEN)) is not None]
    print(f"{len(tried)} settings, {len(wrong)} failures in all")
    print("\n".join(wrong))
    return int(bool(wrong))


def _damaged(folder: Path, bits: int, tails: int) -> list[str]:
    log = small_log(folder)
    data, bad, wrong = log.read_bytes(), folder / "bad.mcap", []
    whole = {name: ask(name, log, folder / f"whole-{name}") for name in COMMANDS}
    counts = dict.fromkeys((0, 2, 3, 4), 0)
    for k, (what, damaged) in enumerate([*flips(data, bits), *cuts(data, tails)]):
        bad.write_bytes(damaged)
        for name, answer in whole.items():
            assert isinstance(answer, Answer)
            found = ask(name, bad, folder / f"{name}-{k}")
            if (line := unsaid(name, answer, found)) is not None:
                wrong.append(f"{what}: {line}")
            elif isinstance(found, Answer):
                counts[found.code] += 1
    print(
        f"{bits} flipped bits and {tails} cuts by {len(COMMANDS)} commands: exit codes {counts}, {len(wrong)} failures"
    )
    return wrong


def _crafted(folder: Path, every: int) -> list[str]:
    log, bad, wrong, count = folder / "run" / "run.mcap", folder / "crafted.mcap", [], 0
    for k, what in enumerate(crafted(log, bad)):
        if k % every:
            continue
        count += 1
        for name in COMMANDS:
            found = ask(name, bad, folder / f"crafted-{k}-{name}")
            if isinstance(found, str):
                wrong.append(f"{what}: {found}")
    print(f"{count} crafted logs by {len(COMMANDS)} commands: {len(wrong)} failures")
    return wrong


sys.exit(main())
