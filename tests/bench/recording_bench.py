"""Compares recording with a bare write of the same bytes, in alternation, on the same disk.

The payloads go through the Recorder as from the receiver's lanes. The time ends when the file is
closed; neither side syncs the disk. Results are medians of the repetitions.
"""

import json
import os
import shutil
import statistics
import tempfile
import time
from pathlib import Path

from ml2_receiver.errors import PublishError
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.frame import CDR_ENCAPSULATION

BUILD = Path(__file__).resolve().parents[2] / "build" / "bench"
TOPIC = load_table().streams["world_left"].topics[0]
# As large as a sensor_msgs/Image of 1016 x 1016 mono8; half of it compresses.
PAYLOAD = CDR_ENCAPSULATION + os.urandom(1016 * 508) + bytes(1016 * 508 + 64)
FRAMES = 300
REPETITIONS = 5
_RETRY_S = 0.0005


def main() -> None:
    """Runs the turns and writes build/bench/recording.json."""
    BUILD.mkdir(parents=True, exist_ok=True)
    bare, plain, zstd, hand_over = [], [], [], []
    with tempfile.TemporaryDirectory(dir=BUILD) as folder:
        for _ in range(REPETITIONS):
            bare.append(write_bare(Path(folder, "bare")))
            rate, hand_over_us = record(Path(folder, "walk"), "none")
            plain.append(rate)
            hand_over.append(hand_over_us)
            zstd.append(record(Path(folder, "walk"), "zstd")[0])
    results = {
        "mb_per_s": statistics.median(plain),
        "zstd_mb_per_s": statistics.median(zstd),
        "bare_mb_per_s": statistics.median(bare),
        "ratio_to_bare": statistics.median(
            ours / theirs for ours, theirs in zip(plain, bare, strict=True)
        ),
        "hand_over_us_per_frame": statistics.median(hand_over),
        "frame_bytes": len(PAYLOAD),
        "frames": FRAMES,
        "repetitions": REPETITIONS,
    }
    (BUILD / "recording.json").write_text(json.dumps(results, indent=2) + "\n")


def write_bare(file: Path) -> float:
    """Writes the payloads in a loop; returns MB/s."""
    began_s = time.monotonic()
    with file.open("wb", buffering=0) as output:
        for _ in range(FRAMES):
            output.write(PAYLOAD)
    took_s = time.monotonic() - began_s
    file.unlink()
    return FRAMES * len(PAYLOAD) / took_s / 1e6


def record(folder: Path, compression: str) -> tuple[float, float]:
    """Records the payloads; returns MB/s, and the us that a lane waits per payload."""
    make_folder(folder, is_overwriting=False)
    began_s = time.monotonic()
    recorder = Recorder(BagWriter(folder, compression), load_table(), "/bench", print)
    publish = recorder.open(TOPIC)
    payload = bytearray(PAYLOAD)
    hand_overs_s = []
    for _ in range(FRAMES):
        while True:
            handed_s = time.monotonic()
            try:
                publish(payload)
            except PublishError:  # the queue is full, because this loop is faster than any lane
                time.sleep(_RETRY_S)
            else:
                break
        hand_overs_s.append(time.monotonic() - handed_s)
    recorder.close()
    took_s = time.monotonic() - began_s
    assert recorder.progress.messages == FRAMES
    shutil.rmtree(folder)
    return FRAMES * len(PAYLOAD) / took_s / 1e6, statistics.median(hand_overs_s) * 1e6


if __name__ == "__main__":
    main()
