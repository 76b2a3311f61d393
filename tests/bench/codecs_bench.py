"""Measures the images that the headset compresses: their sizes, and the time that it takes.

Usage: codecs_bench.py DURATION. Noise decides sizes, so pixels have a deviation of 2 grey levels,
and depth one of 1 mm + 3 mm/m^2. Streams everything compressed for DURATION seconds on loopback,
then times the encoders on images of a headset that sends them raw. Writes build/bench/codecs.json;
there, `slots_mapped_mb` is the most memory that the native library mapped for raw and compressed
images, and `slots_used_mb` the part of it that was written to.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from frame_memory import read_frame_memory, record_frame_memory
from links import NOISE, NOISY
from load_run import load_run
from other_programs import collect, streaming
from processes import PREFIX, ROOT, draw_images
from simulation import compressed_config, raw_config

RESULTS = ROOT / "build" / "bench"
PROGRAM = RESULTS / "codecs"
TOPICS = {
    "world_jpeg80": "world_left/image_raw/compressed",
    "eye_jpeg80": "eye_nasal_left/image_raw/compressed",
    "depth16": "depth/image_raw/compressedDepth",
}
RAW = ("world_left/image_raw", "eye_nasal_left/image_raw", "depth/image_raw")


def main(duration_s: float) -> None:
    with tempfile.TemporaryDirectory(prefix="ml2_codecs") as name:
        folder = Path(name)
        streamed = _stream(folder, duration_s)
        times = _times(_raw_images(folder))
    figures = {
        **{f"{name}_mbit": streamed["mbit"][topic] for name, topic in TOPICS.items()},
        "all_mbit": sum(streamed["mbit"].values()),
        "world_jpeg_cpu_ms": times["world_jpeg"]["own_ms"],
        "world_libjpeg_turbo_ms": times["world_jpeg"]["libjpeg_turbo_ms"],
        "world_libjpeg_plain_ms": times["world_jpeg"]["libjpeg_plain_ms"],
        "eye_jpeg_cpu_ms": times["eye_jpeg"]["own_ms"],
        "depth16_cpu_ms": times["depth16"]["own_ms"],
        "depth16_plain_loop_ms": times["depth16"]["plain_loop_ms"],
        **streamed,
    }
    (RESULTS / "codecs.json").write_text(json.dumps(figures, indent=2) + "\n")


def _stream(folder: Path, duration_s: float) -> dict[str, Any]:
    config = folder / "compressed.yaml"
    config.write_text(compressed_config())
    logs = RESULTS / "codecs_run"
    draw_images(config, NOISY)
    mapped = record_frame_memory(folder)
    (loaded,) = load_run(config, logs, duration_s, headset_options=NOISY)
    memory = read_frame_memory(mapped)
    return {
        "slots_mapped_mb": memory.peak / 1e6,
        "slots_used_mb": memory.used / 1e6,
        "mbit": {
            name.removeprefix(f"{PREFIX}/"): seen["bytes"] * 8e-6 / loaded.duration_s
            for name, seen in loaded.final["topics"].items()
        },
        "drops_after_start": loaded.drops_after_start,
        "cpu_percent": {name: usage.cpu_percent for name, usage in loaded.usage.items()},
    }


def _raw_images(folder: Path) -> list[Path]:
    config = folder / "raw.yaml"
    config.write_text(raw_config(picture_center={"enabled": False}))
    with streaming(config, folder, **dict(it.split("=") for it in NOISE)) as domain:
        received = collect(dict.fromkeys(RAW, "sensor_msgs/msg/Image"), 1, domain, folder)
    files = [folder / f"{number}.raw" for number in range(len(RAW))]
    for file, topic in zip(files, RAW, strict=True):
        file.write_bytes(bytes(received.messages(topic)[0].data))
    return files


def _times(images: list[Path]) -> dict[str, dict[str, float]]:
    """Returns what the program prints, and the time of libjpeg-turbo without its vector code."""
    library = ROOT / "build" / "native"
    source = ROOT / "tests" / "bench" / "codecs.cpp"
    link = (
        f"-L{library / 'device'}",
        "-lml2sensors",
        "-ljpeg",
        "-Wl,--unresolved-symbols=ignore-all",
    )
    subprocess.run(["c++", "-std=c++17", "-O2", "-o", PROGRAM, source, *link], check=True)
    paths = f"{library / 'device'}:{library / 'linux'}:{library / 'host' / 'sim'}"
    environment = os.environ | {"LD_LIBRARY_PATH": paths}
    command = [PROGRAM, *images]
    times = json.loads(subprocess.check_output(command, env=environment))
    plain = environment | {"JSIMD_FORCENONE": "1"}
    for name, row in json.loads(subprocess.check_output(command, env=plain)).items():
        if "libjpeg_turbo_ms" in row:
            times[name]["libjpeg_plain_ms"] = row["libjpeg_turbo_ms"]
    return dict(times)


if __name__ == "__main__":
    main(float(sys.argv[1]))
