"""The core validation layer of Khronos, which pyopenxr brings, watches the library's calls."""

import os
import platform
import subprocess
from importlib.util import find_spec
from pathlib import Path

PROGRAM = Path(__file__).parents[3] / "build/native/address/tests/openxr/openxr_test"
WATCHED = "Extensions*:Events*:Map.*:Markers*:*Either*:*Controller*"
"""Not those with pixel sensors, whose extension is not in Khronos' registry."""
WAITING = "*ForTenSeconds*:*NeverReady*"
"""Tests of limits of seconds, whose calls others make too."""


def test_the_layer_has_nothing_to_say_about_the_calls_of_the_library() -> None:
    found = find_spec("xr")
    assert found is not None
    assert found.submodule_search_locations is not None
    layers = Path(found.submodule_search_locations[0]) / f"api_layer/linux_{platform.machine()}"
    output = subprocess.run(
        [PROGRAM, f"--gtest_filter={WATCHED}-{WAITING}"],
        env={
            **os.environ,
            "XR_API_LAYER_PATH": str(layers),
            "XR_ENABLE_API_LAYERS": "XR_APILAYER_LUNARG_core_validation",
            "XR_CORE_VALIDATION_EXPORT_TYPE": "text",
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    ).stdout
    assert output.count("Core Validation Layer is initialized") > 10, output
    said = [line for line in output.splitlines() if "VALID_ERROR" in line or "VALID_WARN" in line]
    assert said == []
    assert "[  PASSED  ]" in output, output
