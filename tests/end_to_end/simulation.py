"""Names and configurations for the tests of simulated sensors."""

from __future__ import annotations

import subprocess
from typing import Any

import yaml

from processes import ROOT

CAMERAS = ("world_center", "world_left", "world_right", "color", "depth")
EYES = ("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right")
# Options of a headset whose cameras draw one image each, for tests that do not look at images
STILL = ("--simulate", "still_images=1")
# Options of a headset without noise, for tests that compare with the truth
EXACT = ("--simulate", "noise=0")
# An option of a headset to which simulate() writes
SIMULATE = ("--simulate", "-")
# The smallest pictures of the colour camera
SMALL = {"resolution_width": 640, "resolution_height": 480}
_OTHER_IMAGES = ("picture_center", "depth_center", "world_center", "world_right", *EYES)


def simulate(headset: subprocess.Popen[str], *settings: str) -> None:
    """Sets keys of a simulated device while it streams, each as KEY=VALUE; see SIMULATE."""
    assert headset.stdin is not None
    headset.stdin.write("".join(f"{it}\n" for it in settings))
    headset.stdin.flush()


def compressed_config(**changes: dict[str, Any]) -> str:
    """Returns config/demo.yaml with values of some sections changed."""
    tree = yaml.safe_load((ROOT / "config" / "demo.yaml").read_text())
    (node,) = tree.values()
    for section, values in changes.items():
        node["ros__parameters"][section] |= values
    return yaml.safe_dump(tree)


def video_config(**changes: dict[str, Any]) -> str:
    """Returns that configuration with video of world cameras and RGB, and smaller eye images.

    RGB has 1280 x 720 pixels: openh264, which stands for the headset's encoder chip, needs 0.2
    cores for it, and 0.5 for 1920 x 1080.
    """
    cameras = ("world_center", "world_left", "world_right", "picture_center")
    video: dict[str, dict[str, Any]] = {
        **{it: {"format": "h264"} for it in cameras},
        **{it: {"quality": 60} for it in EYES},
    }
    video["picture_center"] |= {"resolution_width": 1280, "resolution_height": 720}
    return compressed_config(**video, **changes)


def raw_config(**changes: dict[str, Any]) -> str:
    """Returns that configuration with raw images at their full rate, whatever is lost."""
    grey = (*(it for it in CAMERAS if it.startswith("world")), *EYES)
    raw: dict[str, dict[str, Any]] = {
        "general": {"link": "fixed"},
        "depth_center": {"format": "Depth32"},
        **{it: {"format": "Grayscale"} for it in grey},
    }
    merged = {it: raw.get(it, {}) | changes.get(it, {}) for it in {*raw, *changes}}
    return compressed_config(**merged)


def five_cameras(**changes: dict[str, Any]) -> str:
    """Returns the demo's configuration without eye cameras, and with small colour pictures."""
    off: dict[str, dict[str, Any]] = {key: {"enabled": False} for key in EYES}
    return raw_config(picture_center=SMALL, **off, **changes)


def one_camera(**changes: dict[str, Any]) -> str:
    """Returns the demo's configuration with world_left as the only camera: a tenth of the load."""
    return raw_config(**{key: {"enabled": False} for key in _OTHER_IMAGES}, **changes)


def compressed_world_and_depth(**changes: dict[str, Any]) -> str:
    """Returns that configuration without the colour camera and the eyes."""
    off: dict[str, dict[str, Any]] = {it: {"enabled": False} for it in ("picture_center", *EYES)}
    return compressed_config(**off, **changes)


def image_topic(camera: str) -> str:
    return f"{camera}/image_raw/compressed" if camera == "color" else f"{camera}/image_raw"
