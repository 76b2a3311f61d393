"""ml2-receiver record --attach: has a receiver that runs record."""

import argparse
from collections.abc import Mapping

from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.errors import RecordingError

from .live import PATIENCE_S, receiver_client, whom
from .recording_wait import Standing, how_long, wait

_ROW = "recording"
_START, _STOP = "start_recording", "stop_recording"


def record_attached(options: argparse.Namespace) -> int:
    """Records until Ctrl-C or the end of --duration.

    Raises:
        RosError: there is no receiver, or it does not answer.
        RecordingError: it does not record, with its reason.
    """
    with receiver_client(options.name, PATIENCE_S, [_START, _STOP]) as (node, client):
        stopping = stop_signal()
        reached = whom(node, client, options.name)
        _done(client.set(_parameters(options)))
        started = _done(client.call(_START))
        print(f"{reached}{started} {how_long(options.duration)}", flush=True)
        folder = str(options.out.absolute())

        def standing() -> Standing:
            return _standing(node.rows(options.name, PATIENCE_S).get(_ROW, {}), folder)

        wait(stopping, options.duration, standing)
        print(_done(client.call(_STOP)))
    return 0


def _parameters(options: argparse.Namespace) -> dict[str, str | int]:
    return {
        "record.folder": str(options.out.absolute()),
        "record.topics": " ".join(options.topic),
        "record.compression": options.compression,
        "record.split_size_mb": options.split_size,
        "record.split_duration_s": options.split_duration,
    }


def _done(answer: tuple[bool, str]) -> str:
    is_done, said = answer
    if not is_done:
        raise RecordingError(said)
    return said


def _standing(row: Mapping[str, str], folder: str) -> Standing:
    """Reads the state from the row of /diagnostics, which may describe the previous recording."""
    if row.get("folder") != folder:
        return Standing(0, 0, 0, "")
    return Standing(
        float(row["duration_s"]),
        int(row["file_bytes"]),
        int(row["messages"]),
        row["message"],
        is_over=row["state"] != "recording",
    )
