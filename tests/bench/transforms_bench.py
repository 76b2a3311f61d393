"""Measures the receiver's CPU while the headset's app follows a frame in 3000 transforms a second.

Usage: transforms_bench.py DURATION, in seconds. Writes build/bench/transforms.json:

cpu_percent, idle_cpu_percent  of one processor, with the transforms and before them
transforms_per_s               as they were published
poses_per_s                    that the app has printed

100 frames have a chain of up to ten transforms to the root. Each moves 30 times per second, and ten
are in a message. The publisher is a process of its own.
"""

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path

from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from configurations import only
from load_run import Usage
from ml2_receiver.ros.context import tool_node
from processes import (
    ROOT,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    paired,
    process,
    receive_command,
)

RESULTS = ROOT / "build" / "bench" / "transforms.json"
ROOT_FRAME, FRAMES, IN_MESSAGE, RATE_HZ = "map", 100, 10, 30
LAST = f"frame_{FRAMES - 1}"
_WARM_UP_S = 5.0


def main(duration_s: float) -> None:
    os.environ |= isolated_environment()
    with tempfile.TemporaryDirectory(prefix="ml2_transforms") as name, ExitStack() as stack:
        folder, logs = Path(name), RESULTS.with_suffix("")
        config = folder / "config.yaml"
        logs.mkdir(parents=True, exist_ok=True)
        config.write_text(only({"battery": {"enabled": True}, "app": {"subscribe": ["/tf"]}}))
        keys = paired(folder)
        command = receive_command(config, "127.0.0.1:0", security=keys)
        receiver = stack.enter_context(process(command, dict(os.environ), logs / "receiver.log"))
        follow = "--transform", LAST, ROOT_FRAME
        command = headset_command(listening_address(receiver), *follow, security=keys)
        headset = stack.enter_context(process(command, dict(os.environ), logs / "headset.log"))
        poses, first = [0], threading.Event()

        def count() -> None:
            for line in lines(headset):
                if line.startswith(f"{LAST} in {ROOT_FRAME} "):
                    poses[0] += 1
                    first.set()

        threading.Thread(target=count, daemon=True).start()
        idle, busy = Usage(receiver.pid), Usage(receiver.pid)
        with subprocess.Popen(
            [sys.executable, __file__, "publish"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as publisher:
            stack.callback(publisher.kill)
            _ask(publisher, 1)  # until the headset has its first pose
            while not first.wait(1):
                _ask(publisher, 1)
            time.sleep(_WARM_UP_S)
            idle.sample()
            time.sleep(duration_s)
            idle.sample()
            before, began_s = poses[0], time.monotonic()
            busy.sample()
            sent = _ask(publisher, duration_s)
            busy.sample()
            passed_s, found = time.monotonic() - began_s, poses[0] - before
            publisher.kill()
    results = {
        "cpu_percent": busy.cpu_percent,
        "idle_cpu_percent": idle.cpu_percent,
        "transforms_per_s": sent / passed_s,
        "poses_per_s": found / passed_s,
        "duration_s": passed_s,
    }
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def _ask(publisher: subprocess.Popen[str], duration_s: float) -> int:
    """Has transforms published for so long, and returns their number."""
    assert publisher.stdin is not None
    assert publisher.stdout is not None
    publisher.stdin.write(f"{duration_s}\n")
    publisher.stdin.flush()
    return int(publisher.stdout.readline())


def publish() -> None:
    """Publishes for as long as each line says, and answers with the number of transforms."""
    with tool_node("transforms") as node:
        publisher = node.create_publisher(TFMessage, "/tf", 100)
        numbers = [range(at, at + IN_MESSAGE) for at in range(0, FRAMES, IN_MESSAGE)]
        messages = [TFMessage(transforms=[_moving(it) for it in of]) for of in numbers]
        sent, began_s = 0, 0.0
        for line in sys.stdin:
            sent, began_s = 0, time.monotonic()
            while (now_s := time.monotonic()) < began_s + float(line):
                message = messages[sent % len(messages)]
                stamp = node.get_clock().now().to_msg()
                for moving in message.transforms:
                    moving.header.stamp = stamp
                    moving.transform.translation.x = now_s
                publisher.publish(message)
                sent += 1
                due_s = began_s + sent / (RATE_HZ * len(messages))
                time.sleep(max(0.0, due_s - time.monotonic()))
            print(sent * IN_MESSAGE, flush=True)


def _moving(number: int) -> TransformStamped:
    made = TransformStamped(child_frame_id=f"frame_{number}")
    above = number - IN_MESSAGE
    made.header.frame_id = ROOT_FRAME if above < 0 else f"frame_{above}"
    return made


if __name__ == "__main__":
    publish() if sys.argv[1] == "publish" else main(float(sys.argv[1]))
