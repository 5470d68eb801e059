"""Where compiled kernels and fonts are kept between runs; without any such place a run still runs."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def see_to_caches() -> None:
    """Let numba and matplotlib keep their caches in a folder that lasts as long as the program where none can be kept.

    numba keeps compiled code beside the source or in the user's cache folder, and gives up where it can't.
    """
    own = [PACKAGE / "__pycache__", user_cache() / "numba"]
    needed = {"NUMBA_CACHE_DIR": own, "MPLCONFIGDIR": [user_cache() / "matplotlib"]}
    missing = [name for name, places in needed.items() if name not in os.environ and not any(map(writable, places))]
    if missing:
        _keep_for_now(missing)


def user_cache() -> Path:
    """Return the user's cache folder, whether it exists or not."""
    named = os.environ.get("XDG_CACHE_HOME")
    return Path(named) if named else Path(os.path.expanduser("~")) / ".cache"


def writable(folder: Path) -> bool:
    """Return whether a folder can be written, or made where it isn't."""
    there = next((one for one in (folder, *folder.parents) if one.exists()), None)
    if there is None or not there.is_dir():
        return False
    try:
        with tempfile.TemporaryFile(dir=there):
            return True
    except OSError:
        return False


def _keep_for_now(names: list[str]) -> None:
    try:
        folder = tempfile.mkdtemp(prefix="topomap-cache-")
    except OSError:  # nowhere at all: whoever needs it says so
        return
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ.update(dict.fromkeys(names, folder))
