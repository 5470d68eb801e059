"""topomap: loop-closing navigation with topological snapshot maps."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from topomap.core.panorama import Panorama
    from topomap.vision.home import home, load

__version__ = version("topomap")
_LAZY = {"home": "topomap.vision.home", "load": "topomap.vision.home", "Panorama": "topomap.core.panorama"}
__all__ = ["Panorama", "__version__", "home", "load"]


def __getattr__(name: str) -> object:
    """Import the Python API when it is first asked for: `import topomap` alone stays light."""
    if name not in _LAZY:
        raise AttributeError(f"module 'topomap' has no attribute {name!r}")
    return getattr(import_module(_LAZY[name]), name)
