"""Histogram equalisation: grey values spread evenly, so that light tells less and edges more."""

from __future__ import annotations

import cv2
import numpy as np

from topomap.core.panorama import Panorama


def equalised(panorama: Panorama) -> Panorama:
    """Return the view in grey with an even histogram, its ranges and rig as they were; made once a view."""
    return panorama.derived("equalised", _equalised)


def _equalised(panorama: Panorama) -> Panorama:
    grey = cv2.equalizeHist(cv2.cvtColor(panorama.image, cv2.COLOR_RGB2GRAY))
    return Panorama(np.repeat(grey[:, :, None], 3, axis=2), panorama.ranges, panorama.rig)
