"""Forwards packets between two namespaces at a rate and with a delay, where tc has no netem.

Usage: delayed_link.py NEAR FAR RATE_MBIT DELAY_MS QUEUE_MS. Makes a TUN device `ml2link` in each of
the namespaces, prints "ready", and forwards until SIGTERM. Packets from FAR wait in a queue of at
most QUEUE_MS at RATE_MBIT; both directions then take DELAY_MS. At the end it prints how many
packets the queue has dropped. Needs root.
"""

import fcntl
import os
import select
import signal
import struct
import sys
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

DEVICE = "ml2link"
# With jumbo packets, Python forwards 400 Mbit/s with a fraction of a processor.
MTU = 9000
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 1, 0x1000


@dataclass
class Direction:
    """The packets of one direction, in the order of their times of arrival."""

    source: int
    target: int
    delay_s: float
    bytes_per_s: float = float("inf")
    queue_s: float = 0.0
    dropped: int = 0
    _free_s: float = 0.0  # then all that was taken is sent
    _flying: deque[tuple[float, bytes]] = field(default_factory=deque)

    def take(self, now_s: float) -> None:
        """Takes all packets that have been sent."""
        with suppress(BlockingIOError):
            while True:
                packet = os.read(self.source, MTU)
                begins_s = max(now_s, self._free_s)
                if begins_s - now_s > self.queue_s:
                    self.dropped += 1
                    continue
                self._free_s = begins_s + len(packet) / self.bytes_per_s
                self._flying.append((self._free_s + self.delay_s, packet))

    def deliver(self, now_s: float) -> float:
        """Delivers what is due; returns the time of the next packet."""
        while self._flying and self._flying[0][0] <= now_s:
            with suppress(OSError):  # a device that is not up, or full, loses it as a link does
                os.write(self.target, self._flying.popleft()[1])
        return self._flying[0][0] if self._flying else float("inf")


def device_in(namespace: str) -> int:
    """Makes the TUN device in a namespace, and returns its descriptor."""
    with Path("/run/netns", namespace).open() as file:
        os.setns(file.fileno(), os.CLONE_NEWNET)
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    request = struct.pack("16sH22x", DEVICE.encode(), _IFF_TUN | _IFF_NO_PI)
    fcntl.ioctl(device, _TUNSETIFF, request)
    return device


def main(near: str, far: str, rate_mbit: str, delay_ms: str, queue_ms: str) -> None:
    receiver, headset = device_in(near), device_in(far)
    delay_s = float(delay_ms) / 1e3
    up = Direction(headset, receiver, delay_s, float(rate_mbit) * 1e6 / 8, float(queue_ms) / 1e3)
    directions = up, Direction(receiver, headset, delay_s)
    stopping = False

    def stop(*_: object) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    print("ready", flush=True)
    while not stopping:
        now_s = time.monotonic()
        next_s = min(it.deliver(now_s) for it in directions)
        wait_s = min(max(0.0, next_s - time.monotonic()), 0.1)
        readable, _, _ = select.select([headset, receiver], [], [], wait_s)
        now_s = time.monotonic()
        for direction in directions:
            if direction.source in readable:
                direction.take(now_s)
    print(up.dropped, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:6])
