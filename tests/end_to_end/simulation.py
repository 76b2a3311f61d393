"""Names and configurations for the tests of simulated sensors."""

from __future__ import annotations

from typing import Any

import yaml

from processes import ROOT

CAMERAS = ("world_center", "world_left", "world_right", "color", "depth")
EYES = ("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right")
# The smallest pictures of the colour camera
SMALL = {"resolution_width": 640, "resolution_height": 480}
_OTHER_IMAGES = ("picture_center", "depth_center", "world_center", "world_right", *EYES)


def demo_config(**changes: dict[str, Any]) -> str:
    """Returns config/demo.yaml with values of some sections changed."""
    tree = yaml.safe_load((ROOT / "config" / "demo.yaml").read_text())
    (node,) = tree.values()
    for section, values in changes.items():
        node["ros__parameters"][section] |= values
    return yaml.safe_dump(tree)


def five_cameras(**changes: dict[str, Any]) -> str:
    """Returns the demo's configuration without eye cameras, and with small colour pictures."""
    off: dict[str, dict[str, Any]] = {key: {"enabled": False} for key in EYES}
    return demo_config(picture_center=SMALL, **off, **changes)


def one_camera(**changes: dict[str, Any]) -> str:
    """Returns the demo's configuration with world_left as the only camera: a tenth of the load."""
    return demo_config(**{key: {"enabled": False} for key in _OTHER_IMAGES}, **changes)


def compressed_config(**changes: dict[str, Any]) -> str:
    """Returns the demo's configuration with all images compressed on the headset."""
    cameras = (*(it for it in CAMERAS if it.startswith("world")), *EYES)
    formats = {**{it: {"format": "jpeg"} for it in cameras}, "depth_center": {"format": "depth16"}}
    return demo_config(
        **{it: formats.get(it, {}) | changes.get(it, {}) for it in {*formats, *changes}}
    )


def compressed_world_and_depth(**changes: dict[str, Any]) -> str:
    """Returns that configuration without the colour camera and the eyes."""
    off: dict[str, dict[str, Any]] = {
        it: {"enabled": False} for it in ("picture_center", *EYES)
    }
    return compressed_config(**off, **changes)


def image_topic(camera: str) -> str:
    return f"{camera}/image_raw/compressed" if camera == "color" else f"{camera}/image_raw"
