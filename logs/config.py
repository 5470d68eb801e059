"""The log section of a run's configuration."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

Compression = Literal["zstd", "lz4", "none"]


class LogConfig(BaseModel):
    """How a run is recorded."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    compression: Compression = Field("zstd", description="compression of the log's chunks: zstd, lz4 or none")
    chunk_size: int = Field(
        262_144, ge=4096, le=16_777_216, description="size at which a chunk is closed [bytes, uncompressed]"
    )
    flush_seconds: float = Field(
        0.5,
        ge=0.0,
        le=60.0,
        description="longest time, of run and wall clock, that steps wait in memory [s]; 0: each step",
    )
