#!/usr/bin/env python3
"""Writes docs/performance.md from the results of `make bench` and `make links` in build/bench.

Run it on the machine that measured: the page names it. A benchmark without results is left out.
"""

import json
import os
import platform
import subprocess
from collections.abc import Iterator, Mapping
from datetime import date
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "build" / "bench"
PAGE = ROOT / "docs" / "performance.md"
_LOAD = RESULTS / "load_average_before.txt"

HEAD = """# Performance

`tests/bench/performance_page.py` generated this page from the results of `make bench` and
`make links`. The sensors were simulated or mocked and all programs ran on one machine, so the
figures contain no Wi-Fi and no headset. CPU time is that of the whole process.

| machine | |
|---|---|
"""


class Measure(NamedTuple):
    """One row: a label, the key of the result, and the unit."""

    label: str
    key: str
    unit: str


class Section(NamedTuple):
    """The measures of one file of build/bench.

    Attributes:
        columns: the titles of columns by the key of their results in the file; if there are none,
            the table has one column, whose results are the file's.
    """

    file: str
    title: str
    text: str
    measures: list[Measure]
    columns: Mapping[str, str] = MappingProxyType({})


SECTIONS = [
    Section(
        "receiver",
        "Receiving an image",
        "A frame of 1 MB from a socket to a ROS subscriber. The bare loop only receives and "
        "publishes the same bytes. ROS-TCP-Endpoint receives the same image from the same sender "
        "and decodes it. Frames are lost where a subscriber's queue overflows.",
        [
            Measure("`ml2-receiver`, CPU per frame", "cpu_ms_per_frame", "ms"),
            Measure("bare loop, CPU per frame", "bare_cpu_ms_per_frame", "ms"),
            Measure("ROS-TCP-Endpoint, CPU per frame", "endpoint_cpu_ms_per_frame", "ms"),
            Measure("`ml2-receiver`, rate", "frames_per_s", "frames/s"),
            Measure("bare loop, rate", "bare_frames_per_s", "frames/s"),
            Measure("ROS-TCP-Endpoint, rate", "endpoint_frames_per_s", "frames/s"),
            Measure("`ml2-receiver`, lost", "lost", "frames"),
            Measure("ROS-TCP-Endpoint, lost", "endpoint_lost", "frames"),
        ],
    ),
    Section(
        "tls",
        "Encryption",
        "A frame of 1 MB from a socket to a sink that discards it.",
        [
            Measure("TLS 1.3, CPU per frame", "tls_cpu_ms_per_frame", "ms"),
            Measure("plaintext, CPU per frame", "plaintext_cpu_ms_per_frame", "ms"),
            Measure("TLS 1.3, one connection", "tls_gbit_per_s", "Gbit/s"),
            Measure("plaintext, one connection", "plaintext_gbit_per_s", "Gbit/s"),
        ],
    ),
    Section(
        "recording",
        "Recording",
        "Frames of 1 MB written to a disk.",
        [
            Measure("`record`", "mb_per_s", "MB/s"),
            Measure("`record --compression zstd`", "zstd_mb_per_s", "MB/s"),
            Measure("bare write of the same bytes", "bare_mb_per_s", "MB/s"),
            Measure("delay of a lane per frame", "hand_over_us_per_frame", "µs"),
        ],
    ),
    Section(
        "products",
        "Products",
        "CPU time from the messages of one frame to the message that is published.",
        [
            Measure("`depth/points`", "points_cpu_ms", "ms"),
            Measure("`depth/points` from `depth16`", "points_from_depth16_cpu_ms", "ms"),
            Measure("`depth/points` with colours of 1920 x 1080", "coloured_points_cpu_ms", "ms"),
            Measure("`world_left/image_raw` from JPEG", "world_raw_from_jpeg_cpu_ms", "ms"),
            Measure("`world_left/image_rect`", "world_rectified_cpu_ms", "ms"),
            Measure("`aligned_depth_to_color`", "depth_to_color_cpu_ms", "ms"),
            Measure("`aligned_depth_to_world_left`", "depth_to_world_cpu_ms", "ms"),
        ],
    ),
    Section(
        "codecs",
        "Compressed images",
        "Images that the headset compresses: JPEG with quality 80, depth in whole millimetres. The "
        "simulated pixels have noise of 2 grey levels, depth of 1 mm + 3 mm/m². The encoders take "
        "turns on the same images.",
        [
            Measure("a world camera, JPEG", "world_jpeg80_mbit", "Mbit/s"),
            Measure("an eye camera, JPEG", "eye_jpeg80_mbit", "Mbit/s"),
            Measure("depth, `depth16`", "depth16_mbit", "Mbit/s"),
            Measure("all streams", "all_mbit", "Mbit/s"),
            Measure("a world image, 1016 x 1016", "world_jpeg_cpu_ms", "ms"),
            Measure("the same by libjpeg-turbo", "world_libjpeg_turbo_ms", "ms"),
            Measure("the same by libjpeg-turbo without vectors", "world_libjpeg_plain_ms", "ms"),
            Measure("a depth image, 544 x 480", "depth16_cpu_ms", "ms"),
            Measure("the same by a plain loop", "depth16_plain_loop_ms", "ms"),
            Measure("native memory of all images, mapped", "slots_mapped_mb", "MB"),
            Measure("the part of it that is used", "slots_used_mb", "MB"),
        ],
    ),
    Section(
        "image_quality",
        "What JPEG costs",
        "Images of a walk, raw with noise of 2 grey levels, and the same pixels as the headset's "
        "JPEGs keep them. Points of a rectified world camera are matched between images 0.13 s "
        "apart; the error is the median distance from the epipolar lines of the true poses. "
        "Structure from motion estimates the walk with five seeds of its random choices; the error "
        "is the rmse of positions against the true ones. A change is relative to raw. `make "
        "image-quality` measured it.",
        [
            Measure("size of an image", "image_kb", "kB"),
            Measure("PSNR", "psnr_db", "dB"),
            *(
                measure
                for kind, name in (
                    ("sift", "SIFT features"),
                    ("orb", "ORB features"),
                    ("flow", "optical flow"),
                )
                for measure in (
                    Measure(f"{name}, error", f"{kind}_median_px", "px"),
                    Measure(f"{name}, change", f"{kind}_median_px_change_percent", "%"),
                )
            ),
            Measure("structure from motion, median seed", "sfm_rmse_mm", "mm"),
            Measure("structure from motion, change", "sfm_rmse_mm_change_percent", "%"),
            Measure("structure from motion, best seed", "sfm_least_rmse_mm", "mm"),
            Measure("structure from motion, worst seed", "sfm_most_rmse_mm", "mm"),
        ],
        {
            "raw": "raw",
            **{f"jpeg{quality}": f"JPEG {quality}" for quality in (90, 80, 60, 40)},
        },
    ),
    Section(
        "lazy_resume",
        "Lazy streams",
        "The time from a new subscription to the first image of a paused stream.",
        [
            Measure("median", "resume_ms_median", "ms"),
            Measure("maximum", "resume_ms_max", "ms"),
        ],
    ),
    Section(
        "memory",
        "Memory of the headset library",
        "Every sensor is on, with depth confidence and flags, and RGB at 1920 x 1080.",
        [
            Measure("slots and buffers, peak", "peak_mb", "MB"),
            Measure("Java heap", "heap_mb", "MB"),
        ],
    ),
    Section(
        "downlink",
        "ROS into the headset",
        "Messages to the app of the simulated headset, beside all streams of config/demo.yaml, "
        "with TLS. Latency is from the call of `publish` in another process until the app has "
        "printed the message. Each kind takes turns with nothing.",
        [
            Measure("latency, half of the messages", "latency_p50_ms", "ms"),
            Measure("latency, 99 % of the messages", "latency_p99_ms", "ms"),
            Measure("messages lost", "lost", ""),
            Measure("IMU sample to subscriber without them, 99 %", "imu_without_p99_ms", "ms"),
            Measure("IMU sample to subscriber with them, 99 %", "imu_p99_ms", "ms"),
            Measure("IMU sample to subscriber without them, 99.9 %", "imu_without_p999_ms", "ms"),
            Measure("IMU sample to subscriber with them, 99.9 %", "imu_p999_ms", "ms"),
            Measure("processors busy without them", "busy_without_percent", "%"),
            Measure("processors busy with them", "busy_percent", "%"),
            Measure("`ml2-receiver`, CPU per message", "receiver_cpu_us_per_message", "µs"),
        ],
        {
            "of_100_b": "100 B, 1000 Hz",
            "of_1_mb": "1 MB, 20 Hz",
            "of_16_mib": "16 MiB, 1 Hz",
        },
    ),
    *[
        Section(
            name,
            title,
            "All streams of config/demo.yaml through library, sockets, receiver and a subscriber.",
            [
                Measure("messages dropped", "drops", ""),
                Measure("messages dropped after the start", "drops_after_start", ""),
                Measure("duration", "duration_s", "s"),
            ],
        )
        for name, title in (("full_load", "Full load"), ("full_load_tls", "Full load with TLS"))
    ],
]


LINKS = """
## Links

**On links of {links} Mbit/s that images filled, 99 % of IMU samples arrived within {p99} ms, beside the time that
the path takes (half the round trip), after the first 3 s.** Only a link that stands still for a second is worse:
nothing can arrive meanwhile. IMU samples lost: {lost}.

`make links` puts a link of a known rate between headset and receiver: two network namespaces and a
token bucket with a queue of 50 ms. Measured on {date}.

| column | is |
|---|---|
| images | what is sent, and how the link changes. With `auto`, compressed images [give way](topics.md#when-the-link-is-too-slow); all others are fixed. `h264` is video of world cameras and of RGB at 1280 x 720, encoded by software on the same 2 cores |
| control | the congestion control of the headset's kernel |
| IMU p50, p99 | half, and 99 %, of the samples of `imu_left` need less from stamp to subscriber |
| after 3 s | p99 without the first 3 s, in which all programs start and the rate of the link is not known |
| world, Hz | rates of the world cameras center, left and right |
| sent | of all streams. After a comma, what messages of 1 MB carried to the headset: each direction has a link of its `own`, or both share one |
| changes | how often images gave way, or came back |

| images | link, Mbit/s | round trip, ms | control | IMU p50, p99, ms | after 3 s, ms | IMU lost | world, Hz | sent, Mbit/s | changes |
|---|---|---|---|---|---|---|---|---|---|
"""  # noqa: E501
CHANGES = """
What followed when the link changed: the longest of all changes.

| column | is the time until |
|---|---|
| backlog | the last sample of before the change had arrived |
| settled | no sample took more than 60 ms any more |
| used | images use 80 % of the link in a second; images that gave way to it may need less |

| images | link after the change, Mbit/s | changes | backlog, s | settled, s | used, s |
|---|---|---|---|---|---|
"""


def main() -> None:
    PAGE.write_text(HEAD + "\n".join([*_machine(), *_links(), *_sections(), ""]), "utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")


def _machine() -> Iterator[str]:
    processors = Path("/proc/cpuinfo").read_text().splitlines()
    model = next((it.partition(":")[2].strip() for it in processors if "model name" in it), "?")
    memory_gb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    commit = ["git", "log", "-1", "--format=%cs"]
    committed = subprocess.check_output(commit, cwd=ROOT, text=True).strip()
    yield f"| processor | {model}, {os.cpu_count()} cores |"
    yield f"| memory | {memory_gb:.0f} GB |"
    yield f"| system | {platform.system()} {platform.release().partition('-')[0]}, " + (
        f"Python {platform.python_version()} |"
    )
    if _LOAD.exists():
        yield f"| load average before `make bench` | {_LOAD.read_text().strip()} |"
    yield f"| sources | of {committed} |"


def _links() -> Iterator[str]:
    file = RESULTS / "links.json"
    if not file.exists():
        return
    rows = json.loads(file.read_text())
    live = [row for row in rows if "stalls" not in row["config"]]
    rates = [row["link_mbit"] for row in live]
    yield LINKS.format(
        date=date.fromtimestamp(file.stat().st_mtime),
        links=f"{min(rates):.0f} to {max(rates):.0f}",
        p99=_text(max(row["imu_p99_after_3_s_ms"] - row["rtt_ms"] / 2 for row in live)),
        lost=sum(row["imu_lost"] for row in rows),
    ).rstrip()
    for row in rows:
        cells = (
            row["config"],
            _text(row["link_mbit"]),
            _text(row["rtt_ms"]),
            row["congestion"],
            f"{_text(row['imu_p50_ms'])}, {_text(row['imu_p99_ms'])}",
            _text(row["imu_p99_after_3_s_ms"]),
            _text(row["imu_lost"]),
            ", ".join(map(_text, row["world_hz"])),
            ", ".join(_text(row[it]) for it in ("sent_mbit", "down_mbit") if it in row),
            str(sum("as configured" in it or "give way" in it for it in row["steps"])),
        )
        yield f"| {' | '.join(cells)} |"
    yield CHANGES.rstrip()
    for row in rows:
        for to_mbit, changes in _by_rate(row.get("changes", [])).items():
            link = "shared" if to_mbit is None else _text(to_mbit)
            times = [_longest(changes, key) for key in ("backlog_s", "settled_s", "filled_s")]
            yield f"| {row['config']} | {link} | {len(changes)} | {' | '.join(times)} |"


def _by_rate(changes: list[dict[str, Any]]) -> dict[float | None, list[dict[str, Any]]]:
    rates = dict.fromkeys(change["to_mbit"] for change in changes)
    return {rate: [it for it in changes if it["to_mbit"] == rate] for rate in rates}


def _longest(changes: list[dict[str, Any]], key: str) -> str:
    times = [change[key] for change in changes]
    return "" if None in times else f"{max(times):.2f}"


def _sections() -> Iterator[str]:
    for section in SECTIONS:
        file = RESULTS / f"{section.file}.json"
        if not file.exists():
            continue
        results = json.loads(file.read_text())
        yield f"\n## {section.title}\n\n{section.text}\n"
        yield from _table(section, results)


def _table(section: Section, results: dict[str, Any]) -> Iterator[str]:
    parts = {title: results.get(key, {}) for key, title in section.columns.items()}
    columns = parts or {"value": results}
    yield f"| measure | {' | '.join(columns)} |\n|---{'|---' * len(columns)}|"
    for label, key, unit in section.measures:
        if any(key in it for it in columns.values()):
            cells = (
                f"{_text(it[key])} {unit}".rstrip() if key in it else "" for it in columns.values()
            )
            yield f"| {label} | {' | '.join(cells)} |"


def _text(value: Any) -> str:
    """Formats a number with its significant digits."""
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if value >= 100 else f"{value:.2g}"


if __name__ == "__main__":
    main()
