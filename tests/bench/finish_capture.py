"""Adds to a capture benchmark's results what others measured: bytes copied, and the device's share."""

import json
import sys
from pathlib import Path


def main(folder: Path) -> None:
    """Reads copies.txt, the bytes of all frames, and device.txt, microseconds; extends capture.json."""
    results = folder / "capture.json"
    report = json.loads(results.read_text())
    device = float((folder / "device.txt").read_text())
    copied = int((folder / "copies.txt").read_text()) / report["frames"]
    report["simulated_device_cpu_us_per_frame"] = device
    report["ratio_to_bare"] = (report["cpu_us_per_frame"] - device) / report["bare_cpu_us_per_frame"]
    report["copied_bytes_per_frame"] = copied
    report["copied_to_payload"] = copied / report["payload_bytes_per_frame"]
    results.write_text(json.dumps(report) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
