"""The sessions whose recordings show all that judge() judges, and how each is recorded."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkdtemp

from ml2_receiver.errors import ReceiverError
from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.json_body import Scalar

from .pairing import ENDS_WITH_US

type Sections = Mapping[str, Mapping[str, Scalar]]

_ON: Mapping[str, Scalar] = {"enabled": True}
_OPENXR: Mapping[str, Scalar] = {"enabled": True, "backend": "openxr"}
_WORLD = ("world_center", "world_left", "world_right")
_EYES = ("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right")
_OTHERS = ("other_sensors", "head_pose", "magnetometer", "gaze", "hands", "controller")
_COLOR: Mapping[str, Scalar] = {
    "enabled": True,
    "resolution_width": 1280,
    "resolution_height": 720,
    "update_rate": 15,
}
_DEPTH: Mapping[str, Scalar] = {"enabled": True, "update_rate": 30, "format": "depth16"}

# The sections of each session's configuration, by its name. Other sections are off.
STEPS: Mapping[str, Sections] = {
    "everything": {
        "picture_center": {**_COLOR, "format": "jpeg"},
        "depth_center": _DEPTH,
        **{it: {"enabled": True, "format": "jpeg"} for it in (*_WORLD, *_EYES)},
        **dict.fromkeys(_OTHERS, _ON),
    },
    "video": {
        "picture_center": {**_COLOR, "format": "h264"},
        **{it: {"enabled": True, "format": "h264"} for it in _WORLD},
        "gaze": _ON,
    },
    "other_modes": {
        "world_left": {"enabled": True, "format": "jpeg", "stream": 1},
        "depth_center": {**_DEPTH, "confidence": True},
    },
    "openxr": {
        "world_left": {**_OPENXR, "format": "jpeg"},
        "depth_center": {**_DEPTH, **_OPENXR},
        "head_pose": _OPENXR,
        "controller": _OPENXR,
        "markers": _ON,
        "map": _ON,
    },
}

# Seconds of each recording. The simulated head and fingers repeat after 4 s; a headset may take
# some more to open all cameras.
SECONDS: Mapping[str, float] = {"everything": 10, "video": 6, "other_modes": 6, "openxr": 8}

_CONNECT_S, _END_S, _POLL_S = 60.0, 10.0, 0.5
_KEPT_LINES = 200
# Its standard input ends with the process that has started it, however that ends. What is killed
# together with it may still write.
_REMOVE = 'cat; for each in 1 2 3; do rm -rf "$0" && exit; sleep 1; done'


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yields a folder that is gone afterwards, also if this process is killed.

    Recordings have images of eyes, and a simulated headset has keys.
    """
    folder = mkdtemp(prefix="ml2-selftest-")
    remove = ["sh", "-c", _REMOVE, folder]
    with subprocess.Popen(remove, stdin=subprocess.PIPE, start_new_session=True):
        yield Path(folder)


def record_step(
    step: str,
    folder: Path,
    options: Sequence[str],
    is_running: Callable[[], bool],
) -> Path:
    """Records a headset from the moment at which it has taken the configuration of a step.

    Returns the recording.

    Args:
        folder: where configuration and recording go.
        options: further ones of `ml2-receiver record`.
        is_running: returns False when no headset can connect any more.

    Raises:
        ReceiverError: no headset has connected, or the receiver ended; the message has its words.
    """
    config, walk = folder / f"{step}.yaml", folder / step
    config.write_text(_configuration(step))
    command = [sys.executable, "-P", "-m", "ml2_receiver", "record", str(walk), "--no-ros"]
    command += ["--config", str(config), *options]
    receiver = subprocess.Popen(
        [*ENDS_WITH_US, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    said: list[str] = []
    configured = threading.Event()
    reader = threading.Thread(target=_read, args=(receiver, said, configured))
    reader.start()
    try:
        deadline_s = time.monotonic() + _CONNECT_S
        while not configured.wait(_POLL_S):
            if time.monotonic() > deadline_s or not is_running():
                break
        if not configured.is_set() or receiver.poll() is not None:
            last = said[-1] if said else "it said nothing"
            raise ReceiverError(
                f"no headset has connected; the receiver: {last}",
                hint="Start the app (`ml2-receiver headset start`), and end other receivers.",
            )
        time.sleep(SECONDS[step])
    finally:
        _end(receiver)
        reader.join()
    return walk


def _read(receiver: subprocess.Popen[str], said: list[str], configured: threading.Event) -> None:
    assert receiver.stdout is not None
    for line in receiver.stdout:
        said.append(line.rstrip())
        del said[:-_KEPT_LINES]
        if " streams: " in line:
            configured.set()
    configured.set()  # it has ended


def _end(receiver: subprocess.Popen[str]) -> None:
    with suppress(ProcessLookupError):
        receiver.send_signal(signal.SIGINT)
    try:
        receiver.wait(_END_S)
    except subprocess.TimeoutExpired:
        receiver.kill()
        receiver.wait()


def _configuration(step: str) -> str:
    """Returns the file with which nothing runs but what the step asks for."""
    sections = {
        it.id: {"enabled": False} for it in load_table().sections.values() if "enabled" in it.keys
    }
    lines = ["/ml2_receiver:", "  ros__parameters:"]
    for section, values in {**sections, **STEPS[step]}.items():
        lines.append(f"    {section}: {json_text(values)}")
    return "\n".join([*lines, ""])
