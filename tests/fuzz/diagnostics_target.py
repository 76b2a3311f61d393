"""Rows of /diagnostics, which any node may publish: tables and pages show them, in proper JSON."""

import json
from collections.abc import Iterator
from typing import NoReturn

from rich.console import Console

from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table
from ml2_tools.doctor.devices import read_device
from ml2_tools.monitoring.latency import TopicLatency
from ml2_tools.monitoring.topic_table import topic_figures, topic_table
from ml2_tools.viewing.plots import clock_uncertainty_ms, received_mbit_per_s
from ml2_tools.viewing.scene import Scene
from ml2_tools.viewing.state import state_of

_ROW, _PAIR, _VALUE = "\n\n", "\n", "="
_WORLD = "/magic_leap2/world_left/image_raw"
_TABLE = load_table()


def seeds() -> Iterator[bytes]:
    """Rows, each a name and pairs KEY=VALUE, in lines."""
    session = "session\nheadset=h\nstate=connected\nstate.world_left=running\ndevice_id=x"
    topic = f"{_WORLD}\nstream=world_left\ntype=sensor_msgs/msg/Image\ngaps=1\nunpublished=0"
    numbers = "\nrate_hz=nan\nexpected_hz=1e999\ndropped.late=3\nmessage=m"
    window = "\nwindow.first_capture_ns=1\nwindow.last_capture_ns=1\nwindow.messages=1"
    others = ("clock\nuncertainty_ns=5", "recording\nstate=on\nfile_bytes=1\nduration_s=inf")
    yield _ROW.join((session, topic + numbers + window, *others)).encode()
    yield b"adaptation\nworld_left.quality=3\nmessage=lowered"


def read(data: bytes) -> None:
    rows = dict(map(_row, data.decode(errors="replace").split(_ROW)))
    state = state_of(rows, dict.fromkeys(rows, 1), {}, "")
    for value in (state, topic_figures(rows), clock_uncertainty_ms(rows)):
        json.loads(json_text(value), parse_constant=_refuse)
    topic_table(rows, Console(width=80))
    received_mbit_per_s(rows)
    read_device(rows, _TABLE)
    Scene("").topics(rows, {"world_left"})
    latency = TopicLatency("world_left", 2)
    latency.arrived(1, 2)
    for _ in range(2):
        latency.reported(rows.get(_WORLD, {}))
    latency.breakdown()


def _row(text: str) -> tuple[str, dict[str, str]]:
    name, *pairs = text.split(_PAIR)
    return name, dict(it.split(_VALUE, 1) for it in pairs if _VALUE in it)


def _refuse(constant: str) -> NoReturn:
    raise AssertionError(f"{constant} is not JSON")
