"""Reads the geometry of the simulated room from the simulation, in ROS's axes."""

from __future__ import annotations

import ctypes
import json
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from processes import ROOT

LIBRARY = ROOT / "build" / "native" / "host" / "sim" / "libperception.magicleap.so"

# From the device's axes (x right, y up, z backward) to REP 103's (x forward, y left, z up).
TO_ROS = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]])


@dataclass(frozen=True)
class Room:
    """The geometry of the room in magicleap_world, in metres.

    Attributes:
        tags: the four corners by ArUco id, clockwise from the marker's top left.
        normals: the walls' normals, which point into the room.
        offsets_m: points p on wall i have normals[i] @ p = offsets_m[i].
    """

    tags: dict[int, NDArray[np.float64]]
    normals: NDArray[np.float64]
    offsets_m: NDArray[np.float64]


def simulated_room() -> Room:
    """Reads the room from ml2sim_landmarks in native/sim/ml2sim.h."""
    describe = ctypes.CDLL(str(LIBRARY)).ml2sim_landmarks
    describe.restype = ctypes.c_char_p
    known = json.loads(describe())
    return Room(
        {tag["id"]: np.array(tag["corners"]) @ TO_ROS.T for tag in known["tags"]},
        np.array([wall["normal"] for wall in known["walls"]]) @ TO_ROS.T,
        np.array([wall["offset_m"] for wall in known["walls"]]),
    )
