"""Measures the memory of a headset that sends every sensor with every plane.

Usage: memory_bench.py DURATION. Writes build/bench/memory.json, in MB:

slots_mb    the peak of memory that libml2sensors.so maps for frames
direct_mb   the peak of Java's direct buffers, for frame headers and TLS
color_mb    the upper bound for the RGB camera on Android, with all its JPEGs and images; computed
            from its code, because the simulation does not use Android's camera
peak_mb     the sum of the three
left_mb     memory that libml2sensors.so still maps at the end, which a stream leaked
heap_mb     the size to which the virtual machine grew Java's heap
rss_mb      the whole process, with the virtual machine and the cached frames of the simulation
"""

import json
import os
import re
import sys
import tempfile
from pathlib import Path

from frame_memory import read_frame_memory, record_frame_memory
from full_load import RESULTS
from load_run import load_run
from processes import draw_images
from simulation import raw_config

_JAVA_OPTIONS = (
    "-XX:+UnlockDiagnosticVMOptions -XX:NativeMemoryTracking=summary -XX:+PrintNMTStatistics"
)
_MB = 1e6
# ColorCapture.kt: 8 JPEGs of 1 byte per pixel. ImageCopier.kt: NV21 for 4 workers, and one more.
_COLOR_BYTES_PER_PIXEL = 8 + 5 * 1.5


def main(duration_s: float) -> None:
    RESULTS.mkdir(parents=True, exist_ok=True)
    logs = RESULTS / "memory"
    with tempfile.TemporaryDirectory(prefix="ml2_memory") as name:
        config = Path(name) / "everything.yaml"
        config.write_text(re.sub(r"(confidence|flags): false", r"\1: true", raw_config()))
        draw_images(config, ())
        mapped = record_frame_memory(Path(name))
        os.environ["JAVA_TOOL_OPTIONS"] = _JAVA_OPTIONS
        (loaded,) = load_run(config, logs, duration_s)
        slots = read_frame_memory(mapped)
    log = (logs / "one" / "headset.log").read_text()
    direct_bytes = _direct_peak_bytes(log)
    sizes = re.findall(r"resolution_(?:width|height): (\d+)", raw_config())
    color_bytes = int(sizes[0]) * int(sizes[1]) * _COLOR_BYTES_PER_PIXEL
    results = {
        "peak_mb": (slots.peak + direct_bytes + color_bytes) / _MB,
        "slots_mb": slots.peak / _MB,
        "direct_mb": direct_bytes / _MB,
        "color_mb": color_bytes / _MB,
        "left_mb": slots.left / _MB,
        "heap_mb": _heap_bytes(log) / _MB,
        "rss_mb": max(loaded.usage["headset"].rss_bytes) / _MB,
        "duration_s": loaded.duration_s,
    }
    (RESULTS / "memory.json").write_text(json.dumps(results, indent=2) + "\n")


def _direct_peak_bytes(log: str) -> int:
    """Reads the peak of direct buffers, which the virtual machine's statistics call Other."""
    other = re.search(r"Other \(reserved=(\d+).*?\((?:peak=(\d+)|at peak)", log, re.DOTALL)
    if other is None:
        raise SystemExit("the headset's log has no memory statistics: did it end early?")
    return int(other[2] or other[1])


def _heap_bytes(log: str) -> int:
    heap = re.search(r"Java Heap \(reserved=\d+, committed=(\d+)\)", log)
    return int(heap[1]) if heap else 0


if __name__ == "__main__":
    main(float(sys.argv[1]))
