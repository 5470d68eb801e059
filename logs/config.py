"""The log section of a run's configuration."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

Compression = Literal["zstd", "lz4", "none"]


class LogConfig(BaseModel):
    """How a run is recorded."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    compression: Compression = Field("zstd", description="compression of the log's chunks: zstd, lz4 or none")
