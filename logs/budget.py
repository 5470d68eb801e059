"""How much a log may unpack to, told before the memory is taken: a small file can claim gigabytes."""

from __future__ import annotations

from dataclasses import dataclass

from logs.errors import LogError

CHUNK_LIMIT = 64_000_000
"""Most bytes of one chunk, unpacked: the recorder closes chunks at 262 144, one message may be larger."""
SPARE_BYTES, UNPACKED_RATIO = 64_000_000, 200
"""All chunks together: so many bytes and so many a byte of the file. The message index, which isn't packed, keeps a
log of identical frames under 85."""
SPARE_MESSAGES, BYTES_PER_MESSAGE = 10_000, 4
"""So many messages and one for so many bytes of the file: the message index alone takes 16 bytes each."""
GATHERED_RATIO = 4
"""What is kept of a log besides images and ranges: `SPARE_BYTES` and so many bytes a byte of the file."""
FIELD_LIMIT, FIELD_FREE = 1_000_000, 1_000_000
"""Most values of one message longer than FIELD_FREE bytes; a finished map of 100 000 nodes has 300 000."""
IMAGE_LIMIT = 64_000_000
"""Most pixels of an image [px]: the largest camera has 7200 x 2000."""


@dataclass(slots=True)
class Budget:
    """What may still be unpacked in one pass over a file."""

    bytes_left: int
    messages_left: int

    @staticmethod
    def of(size: int) -> Budget:
        """Return the budget of a file of so many bytes."""
        return Budget(SPARE_BYTES + UNPACKED_RATIO * size, SPARE_MESSAGES + size // BYTES_PER_MESSAGE)

    def take(self, count: int, messages: int) -> None:
        """Spend bytes and messages; raises LogError when there aren't so many."""
        self.bytes_left -= count
        self.messages_left -= messages
        if self.bytes_left < 0 or self.messages_left < 0:
            raise LogError("its chunks unpack to more than any log of its size holds: it isn't read")


def gathered_limit(size: int) -> int:
    """Return how many bytes of messages are kept at once of a file of so many bytes."""
    return SPARE_BYTES + GATHERED_RATIO * size
