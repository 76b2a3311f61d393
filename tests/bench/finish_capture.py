"""Adds the copied bytes and the simulated device's CPU time to a capture benchmark's results."""

import json
import sys
from pathlib import Path


def main(folder: Path) -> None:
    """Adds copies.txt (bytes of all frames) and device.txt (us per frame) to capture.json."""
    results = folder / "capture.json"
    report = json.loads(results.read_text())
    device = float((folder / "device.txt").read_text())
    copied = int((folder / "copies.txt").read_text()) / report["frames"]
    report["simulated_device_cpu_us_per_frame"] = device
    own = report["cpu_us_per_frame"] - device
    report["ratio_to_bare"] = own / report["bare_cpu_us_per_frame"]
    report["copied_bytes_per_frame"] = copied
    report["copied_to_payload"] = copied / report["payload_bytes_per_frame"]
    results.write_text(json.dumps(report) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
