"""Odometry that fails for a while: what the odometer read is spoilt, and nothing in the reading tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim2d.config import OdometryFaultConfig
from sim2d.records import OdometerReading


class OdometryFaults:
    """Spoils readings while a fault lasts; `noise` draws two numbers a step for each fault that is on."""

    def __init__(self, faults: tuple[OdometryFaultConfig, ...], noise: np.random.Generator) -> None:
        self._faults = faults
        self._noise = noise
        self._jumped: set[int] = set()

    def spoil(self, reading: OdometerReading, seconds: float, handed_over_s: float | None) -> OdometerReading:
        """Return the reading of a step that ended at `seconds` of run time, so long after the driver handed over."""
        for number, fault in enumerate(self._faults):
            now = seconds if fault.at_s is not None else handed_over_s
            start = fault.at_s if fault.at_s is not None else fault.handed_over_s
            if now is None or start is None or now < start:
                continue
            if fault.lasts_s is None or now < start + fault.lasts_s:
                reading = self._spoilt(reading, fault, number)
        return reading

    def _spoilt(self, reading: OdometerReading, fault: OdometryFaultConfig, number: int) -> OdometerReading:
        draws = self._noise.standard_normal(2)
        jump, turned = (0.0, 0.0) if number in self._jumped else (fault.jump, fault.jump_turn)
        self._jumped.add(number)
        turned += fault.turn_per_m * reading.forward
        return replace(
            reading,
            forward=fault.forward_scale * reading.forward + fault.forward_noise * float(draws[0]) + jump,
            turn=fault.turn_scale * reading.turn + fault.turn_noise * float(draws[1]) + turned,
        )
