"""The memory of a headset that sends every sensor and every plane at once.

Usage: memory_bench.py DURATION. Writes memory.json in build/bench, in MB:

slots_mb    mapped by libml2sensors.so for frames, at most at a time
direct_mb   of Java's direct buffers, at most at a time: heads of frames, TLS
color_mb    what the RGB camera has on Android, which the simulation stands in for: not measured
            but the bound of its code, every JPEG and every image on its way to be one
peak_mb     the three together
left_mb     mapped by libml2sensors.so at the end: memory that a stream kept
heap_mb     Java's heap as the virtual machine had grown it
rss_mb      of the whole process, with the virtual machine and the films of the simulation
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from full_load import DEMO, RESULTS
from load_run import load_run
from processes import ROOT

_JAVA_OPTIONS = (
    "-XX:+UnlockDiagnosticVMOptions -XX:NativeMemoryTracking=summary -XX:+PrintNMTStatistics"
)
_MB = 1e6
# ColorCapture.kt: 8 JPEGs of a byte for each pixel. ImageCopier.kt: NV21 for 4 workers, one more.
_COLOR_BYTES_PER_PIXEL = 8 + 5 * 1.5


def main(duration_s: float) -> None:
    library = RESULTS / "libmapped.so"
    RESULTS.mkdir(parents=True, exist_ok=True)
    _compile(library)
    logs = RESULTS / "memory"
    with tempfile.TemporaryDirectory(prefix="ml2_memory") as name:
        mapped = Path(name) / "mapped.txt"
        config = Path(name) / "everything.yaml"
        config.write_text(re.sub(r"(confidence|flags): false", r"\1: true", DEMO.read_text()))
        os.environ |= {
            "LD_PRELOAD": str(library),
            "ML2S_MAPPED": str(mapped),
            "JAVA_TOOL_OPTIONS": _JAVA_OPTIONS,
        }
        (loaded,) = load_run(config, logs, duration_s)
        slots_bytes, left_bytes = map(int, mapped.read_text().split())
    said = (logs / "one" / "headset.log").read_text()
    direct_bytes = _direct_peak_bytes(said)
    sizes = re.findall(r"resolution_(?:width|height): (\d+)", DEMO.read_text())
    color_bytes = int(sizes[0]) * int(sizes[1]) * _COLOR_BYTES_PER_PIXEL
    results = {
        "peak_mb": (slots_bytes + direct_bytes + color_bytes) / _MB,
        "slots_mb": slots_bytes / _MB,
        "direct_mb": direct_bytes / _MB,
        "color_mb": color_bytes / _MB,
        "left_mb": left_bytes / _MB,
        "heap_mb": _heap_bytes(said) / _MB,
        "rss_mb": max(loaded.usage["headset"].rss_bytes) / _MB,
        "duration_s": loaded.duration_s,
    }
    (RESULTS / "memory.json").write_text(json.dumps(results, indent=2) + "\n")


def _compile(library: Path) -> None:
    sources = ROOT / "tests" / "bench"
    script = f"-Wl,--version-script={sources / 'mapped.map'}"
    command = ["cc", "-shared", "-fPIC", "-O2", script, "-o", library, sources / "mapped.c"]
    subprocess.run([str(it) for it in command], check=True)


def _direct_peak_bytes(said: str) -> int:
    """The virtual machine's statistics at its end name direct buffers Other, and their peak."""
    other = re.search(r"Other \(reserved=(\d+).*?\((?:peak=(\d+)|at peak)", said, re.DOTALL)
    if other is None:
        raise SystemExit("the headset's log has no statistics of memory: did it end early?")
    return int(other[2] or other[1])


def _heap_bytes(said: str) -> int:
    heap = re.search(r"Java Heap \(reserved=\d+, committed=(\d+)\)", said)
    return int(heap[1]) if heap else 0


if __name__ == "__main__":
    main(float(sys.argv[1]))
