"""All of it: `python -m tests.fuzz` writes a line a failure and ends with code 1 if there is one.

200 flipped bits, 50 cuts and every crafted log by five commands, and every senseless setting: half an hour of one core.
`--part damage`, `crafted` or `settings` is one of the three; `--keep FILE` adds what came of it to a CSV file.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "helpers")]

from fuzz.crafted import crafted  # noqa: E402 the path comes first
from fuzz.damage import COMMANDS, Answer, ask, cuts, flips, unsaid  # noqa: E402
from fuzz.settings import words, wrong_with  # noqa: E402
from fuzz.small_log import small_log  # noqa: E402

DEN = str(Path(__file__).parents[1] / "helpers" / "den.toml")
MOST_MB = 1000
"""Memory that all of this may take."""
HEAD = ("attack", "inputs", "answers", "exit codes", "failures", "slowest [s CPU]", "peak memory [MB]")


@dataclass
class Tally:
    """What came of one kind of attack: inputs, answers by exit code, failures a line each, the slowest answer [s]."""

    name: str
    inputs: int = 0
    codes: dict[int, int] = field(default_factory=lambda: dict.fromkeys((0, 2, 3, 4), 0))
    wrong: list[str] = field(default_factory=list)
    slowest: float = 0.0

    def count(self, found: Answer) -> None:
        self.codes[found.code] = self.codes.get(found.code, 0) + 1
        self.slowest = max(self.slowest, found.seconds)

    def cells(self) -> tuple[str, ...]:
        """Return the tally under HEAD; memory that grew beyond its bound is a failure too."""
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        if peak > MOST_MB:
            self.wrong.append(f"{self.name}: {peak} MB of memory")
        codes = ", ".join(f"{count} x {code}" for code, count in self.codes.items() if count)
        answers = sum(self.codes.values())
        return (
            self.name,
            f"{self.inputs}",
            f"{answers}",
            codes,
            f"{len(self.wrong)}",
            f"{self.slowest:.1f}",
            f"{peak}",
        )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", choices=["damage", "crafted", "settings"], help="one of the three")
    parser.add_argument("--flips", type=int, default=200)
    parser.add_argument("--cuts", type=int, default=50)
    parser.add_argument("--every", type=int, default=1, help="only every so-manieth crafted log and setting")
    parser.add_argument("--keep", type=Path, help="CSV file that the figures are added to")
    asked = parser.parse_args()
    parts: dict[str, Callable[[Path], Tally]] = {
        "damage": lambda folder: _damaged(folder, asked.flips, asked.cuts),
        "crafted": lambda folder: _crafted(folder, asked.every),
        "settings": lambda _: _settings(asked.every),
    }
    made: list[tuple[str, ...]] = []
    wrong: list[str] = []
    for name in [asked.part] if asked.part else parts:
        with tempfile.TemporaryDirectory() as folder:
            found = parts[name](Path(folder))
        made.append(found.cells())
        wrong += found.wrong
        print("; ".join(f"{head}: {cell}" for head, cell in zip(HEAD, made[-1], strict=True)), flush=True)
    print("\n".join(wrong))
    if asked.keep is not None:
        _keep(asked.keep, made)
    return int(bool(wrong))


def _damaged(folder: Path, bits: int, tails: int) -> Tally:
    log, tally = small_log(folder), Tally("flipped bits and cuts")
    data, bad = log.read_bytes(), folder / "bad.mcap"
    whole = {name: ask(name, log, folder / f"whole-{name}") for name in COMMANDS}
    for k, (what, damaged) in enumerate([*flips(data, bits), *cuts(data, tails)]):
        tally.inputs += 1
        bad.write_bytes(damaged)
        for name, answer in whole.items():
            assert isinstance(answer, Answer)
            found = ask(name, bad, folder / f"{name}-{k}")
            if (line := unsaid(name, answer, found)) is not None:
                tally.wrong.append(f"{what}: {line}")
            elif isinstance(found, Answer):
                tally.count(found)
    return tally


def _crafted(folder: Path, every: int) -> Tally:
    log, bad, tally = small_log(folder), folder / "crafted.mcap", Tally("crafted logs")
    for k, what in enumerate(crafted(log, bad)):
        if k % every:
            continue
        tally.inputs += 1
        for name in COMMANDS:
            found = ask(name, bad, folder / f"crafted-{k}-{name}")
            if isinstance(found, str):
                tally.wrong.append(f"{what}: {found}")
            else:
                tally.count(found)
    return tally


def _settings(every: int) -> Tally:
    tally = Tally("senseless settings")
    for word in list(words())[::every]:
        tally.inputs += 1
        began = time.process_time()
        line = wrong_with(word, DEN)
        if line is not None:
            tally.wrong.append(line)
        else:
            tally.count(Answer(2, "", {}, time.process_time() - began))
    return tally


def _keep(path: Path, made: list[tuple[str, ...]]) -> None:
    from topomap.experiments.results import add_results

    add_results(path, HEAD, made, keys=1, program="python -m tests.fuzz")


sys.exit(main())
