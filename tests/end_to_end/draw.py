"""Renders images of the simulated headset into its cache, where they are missing.

Usage: draw.py SETTINGS IMAGES, both in JSON: a list of KEY=VALUE, and a list of what ml2sim_images
of native/sim/ml2sim.h has. Prints "kept" if the cache has room for all.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

_LIBRARY = Path(__file__).resolve().parents[2] / "build/native/host/sim/libperception.magicleap.so"
_NICENESS = 5
_NO_ROOM = 1


class _Images(ctypes.Structure):
    _fields_ = (
        ("camera", ctypes.c_char_p),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("rate_hz", ctypes.c_uint32),
        ("low_exposure", ctypes.c_uint32),
        ("depth_planes", ctypes.c_uint32),
    )


def main(settings: list[str], cameras: list[dict[str, str | int]]) -> None:
    os.nice(_NICENESS)
    library = ctypes.CDLL(str(_LIBRARY))
    for setting in settings:
        key, _, value = setting.partition("=")
        # It refuses keys of Android and OpenXR, which change no image.
        library.ml2sim_set(key.encode(), value.encode())
    images = [_Images(str(it.pop("camera")).encode(), **it) for it in cameras]
    with ThreadPoolExecutor(2) as threads:
        drawn = list(threads.map(lambda it: library.ml2sim_draw(ctypes.byref(it)), images))
    for found, wanted in zip(drawn, images, strict=True):
        assert found in (0, _NO_ROOM), f"the device has no such images of {wanted.camera!r}"
    if not any(drawn):
        print("kept")


main(*map(json.loads, sys.argv[1:]))
