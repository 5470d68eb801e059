"""Writes a log at 20 steps a second until it is killed, telling each step's number once it was written."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from log_samples import EPOCH, header, write_step

from logs.recorder import Recorder

RATE = 20


def main() -> None:
    rng = np.random.default_rng(0)
    recorder = Recorder(Path(sys.argv[1]), header())
    start = time.monotonic()
    for i in range(100_000):
        write_step(recorder, EPOCH + i * 1_000_000_000 // RATE, rng)
        sys.stdout.write(f"{i}\n")
        sys.stdout.flush()
        time.sleep(max(0.0, start + (i + 1) / RATE - time.monotonic()))


main()
