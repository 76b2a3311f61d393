"""The table of sensors in README.md."""

from collections.abc import Iterator

from ml2_receiver.errors import TableError
from ml2_receiver.table.stream_table import Stream, StreamTable

# The names of groups of streams, by the prefix of their ids, and what to add to their rates.
_NAMES = {
    "world_": ("Tracking cameras", ""),
    "color": ("RGB camera", ""),
    "mixed_reality": ("Mixed reality", ""),
    "depth": ("Depth camera", ""),
    "infra": ("Depth camera, raw infrared", ""),
    "eye_": ("Eye cameras", ""),
    "accel_": ("Accelerometers", "device's fastest"),
    "gyro_": ("Gyroscopes", "device's fastest"),
    "imu_": ("IMUs (both, joined)", "device's fastest"),
    "light_sensor": ("Ambient light", ""),
    "head_pose": ("Head pose", ""),
    "magnetometer_": ("Magnetometers", ""),
    "pressure_": ("Barometers", ""),
    "gaze": ("Gaze", ""),
    "hand_": ("Hand joints", ""),
    "controller_joy": ("Controller's buttons and touchpad", ""),
    "controller": ("Controller", ""),
    "markers": ("Markers", ""),
    "map": ("Map of the headset", ""),
    "battery": ("Battery", ""),
    "tf": ("Transforms", ", and one per image"),
    "custom": ("Your app's own topics", "yours"),
}


def sensor_table(table: StreamTable) -> Iterator[str]:
    """Yields the lines of the table.

    Raises:
        TableError: a stream has no name for people.
    """
    yield "| sensor | topic | type | rate in Hz | permission |"
    yield "|---|---|---|---|---|"
    groups: dict[str, list[Stream]] = {}
    for stream in table.streams.values():
        prefix = next((it for it in _NAMES if stream.id.startswith(it)), None)
        if prefix is None:
            raise TableError(f"expected a row for {stream.id} in _NAMES of config/sensor_table.py")
        groups.setdefault(prefix, []).append(stream)
    for prefix, streams in groups.items():
        name, note = _NAMES[prefix]
        first = streams[0].topics[0] if streams[0].topics else None
        permissions = table.sections[streams[0].section].permissions
        yield _row(
            name,
            _topics(streams) if first else "`custom/NAME`",
            first.type.replace("/msg/", "/") if first else "any",
            f"{_rates(table, streams[0])}{note}" or "as delivered",
            ", ".join(it.rpartition(".")[2] for it in permissions),
        )


def _topics(streams: list[Stream]) -> str:
    """Returns the main topics, and what a camera's are called in its other formats."""
    first, *others = streams[0].topics
    formats = [it.name.partition("/")[2] for it in others if it.role == first.role]
    return " or ".join(
        [f"`{_braced([it.topics[0].name for it in streams])}`", *map("`{}`".format, formats)]
    )


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |".replace("|  |", "| |")


def _braced(names: list[str]) -> str:
    """Returns names as the shell's braces join them: a_left, a_right -> a_{left,right}."""
    if len(names) == 1:
        return names[0]
    start = _common(names)
    end = _common([name[::-1] for name in names])[::-1]
    middles = (name[len(start) : len(name) - len(end)] for name in names)
    return f"{start}{{{','.join(middles)}}}{end}"


def _common(names: list[str]) -> str:
    """Returns the longest beginning that all names share, up to a separator."""
    length = next(
        (index for index, letters in enumerate(zip(*names, strict=False)) if len(set(letters)) > 1),
        min(map(len, names)),
    )
    shared = names[0][:length]
    return shared[: max(shared.rfind("_"), shared.rfind("/")) + 1]


def _rates(table: StreamTable, stream: Stream) -> str:
    when = stream.when or {}
    modes = [
        mode
        for mode in table.sections[stream.section].modes
        if mode.stream in when.get("stream", (mode.stream,))
    ]
    rates = {rate for mode in modes for rate in mode.rates}
    return ", ".join(map(str, sorted(rates) or filter(None, [stream.pace.rate_hz])))
