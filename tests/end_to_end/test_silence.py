"""Sources of every kind fall silent at once: each command says so, and says when they recovered.

Light and battery may be silent for 60 s and 600 s. That the receiver judges them by these pauses is
tested in host_receiver/test/test_diagnostics_streams.py, with a clock that the test sets.
"""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from capture_stamps import stamp_ns
from counters import Snapshot
from ml2_receiver.topics.judgement import read_judgements
from ml2_receiver.topics.stamps import stamp_reader
from processes import Received, headset_command
from simulation import SIMULATE, SMALL, STILL, compressed_config, simulate
from waiting_receiver import WaitingReceiver, waiting_receiver

# One camera of each kind
OTHERS = ("world_center", "world_right", "eye_nasal_right", "eye_temple_left", "eye_temple_right")
CONFIG = compressed_config(
    general={"link": "fixed"},
    picture_center=SMALL | {"update_rate": 15},
    depth_center={"update_rate": 5},
    **{id: {"enabled": False} for id in OTHERS},
)
PATIENT = ("light_sensor", "battery")
SILENT = (
    *("world_left", "color", "depth", "eye_nasal_left"),
    *("head_pose", "gaze", "hand_left", "hand_right", "controller", "controller_joy", "tf"),
    *("accel_left", "accel_right", "accel_compute_pack"),
    *("gyro_left", "gyro_right", "gyro_compute_pack"),
    *("magnetometer_left", "magnetometer_right", "pressure_headset", "pressure_compute_pack"),
)
COMMANDS = ("devices", "topics", "doctor")

type States = dict[str, str]
type Outputs = dict[str, subprocess.CompletedProcess[str]]


@dataclass(frozen=True)
class Silence:
    """One session in which all sources were silent for a while.

    Attributes:
        silent: what each command printed during the silence, as JSON.
        recovered: the same after it.
        times_ns: when the fault began, when all were reported as silent, and when it ended.
    """

    silent: Outputs
    recovered: Outputs
    received: Received
    times_ns: tuple[int, int, int]


@pytest.fixture(scope="module")
def silence(tmp_path_factory: pytest.TempPathFactory) -> Silence:
    folder = tmp_path_factory.mktemp("silence")
    config = folder / "config.yaml"
    config.write_text(CONFIG)
    with (
        waiting_receiver(config, folder) as waiting,
        waiting.started("headset", headset_command(waiting.address, *STILL, *SIMULATE)) as headset,
    ):
        waiting.await_snapshot(are_running)
        begin_ns = time.time_ns()
        simulate(headset, f"fault.silent={','.join((*SILENT, *PATIENT))}")
        waiting.await_snapshot(are_silent)
        reported_ns = time.time_ns()
        silent = outputs(waiting)
        end_ns = time.time_ns()
        simulate(headset, "fault.silent=")
        waiting.await_snapshot(are_running)
        # The commands fill a small machine, whose receiver may find another silence meanwhile.
        recovered = outputs(waiting)
        while not tell_recovery(recovered):
            recovered = outputs(waiting)
        headset.terminate()
        times_ns = (begin_ns, reported_ns, end_ns)
        return Silence(silent, recovered, waiting.result(), times_ns)


def states_of(session: dict[str, str]) -> States:
    return {id: it.state for id, it in read_judgements(session).items()}


def are_running(snapshot: Snapshot) -> bool:
    states = states_of(snapshot["session"])
    return all(states.get(id) == "running" for id in (*SILENT, *PATIENT))


def are_silent(snapshot: Snapshot) -> bool:
    states = states_of(snapshot["session"])
    return all(states.get(id) in ("silent", "waiting") for id in SILENT)


def outputs(waiting: WaitingReceiver) -> Outputs:
    """Runs all commands beside each other."""
    with ThreadPoolExecutor(len(COMMANDS)) as pool:
        results = pool.map(lambda it: waiting.run(it, "--json"), COMMANDS)
        return dict(zip(COMMANDS, results, strict=True))


def tell_recovery(outputs: Outputs) -> bool:
    found = {name: json.loads(it.stdout) for name, it in outputs.items()}
    devices = {it["stream"]: it["state"] for it in found["devices"]["streams"]}
    topics = {it["stream"]: it["stream_state"] for it in found["topics"]}
    (doctor,) = (it["level"] for it in found["doctor"] if it["check"] == "streams")
    states = {(devices[stream], topics[stream]) for stream in SILENT}
    return states == {("runs", "running")} and doctor == "ok"


def topic_of(received: Received, stream: str) -> str:
    """Returns the full name of the stream's first topic."""
    name: str = received.snapshot["streams"][stream]["topics"][0]["topic"]
    return name


def stamps_ns(received: Received, stream: str) -> list[int]:
    type, payloads = received.topics[topic_of(received, stream)]
    return sorted(map(stamp_reader(type), payloads))


def judged(received: Received) -> Iterator[tuple[int, States, dict[str, Any]]]:
    """Yields the stamp of each /diagnostics, the states in it, and the level of each row."""
    for payload in received.diagnostics:
        array = deserialize_message(payload, DiagnosticArray)
        rows = {it.name.partition(": ")[2]: it for it in array.status}
        session = {pair.key: pair.value for pair in rows["session"].values}
        levels = {name: row.level[0] for name, row in rows.items()}
        yield stamp_ns(array), states_of(session), levels


def test_diagnostics_tell_the_silence_of_each_source(silence: Silence) -> None:
    begin_ns, _, end_ns = silence.times_ns
    found = [it for it in judged(silence.received) if begin_ns < it[0] < end_ns]
    for stream in SILENT:
        row = topic_of(silence.received, stream)
        told_ns = next(at for at, states, levels in found if states[stream] != "running")
        told = [(states, levels) for at, states, levels in found if at >= told_ns]
        assert all(states[stream] in ("silent", "waiting") for states, _ in told), stream
        assert all(levels[row] > 0 and levels["session"] > 0 for _, levels in told), stream


def test_diagnostics_tell_the_recovery_of_each_source(silence: Silence) -> None:
    found = [states for at, states, _ in judged(silence.received) if at > silence.times_ns[2]]
    for stream in SILENT:
        assert any(states[stream] == "running" for states in found), stream


def test_light_and_battery_may_be_silent_for_so_long(silence: Silence) -> None:
    begin_ns, reported_ns, end_ns = silence.times_ns
    for stream in PATIENT:
        assert not any(reported_ns < it < end_ns for it in stamps_ns(silence.received, stream))
        found = [states for at, states, _ in judged(silence.received) if begin_ns < at < end_ns]
        assert {states[stream] for states in found} == {"running"}


def test_devices_tell_the_silence_and_the_recovery(silence: Silence) -> None:
    silent, recovered = (
        {it["stream"]: it for it in json.loads(outputs["devices"].stdout)["streams"]}
        for outputs in (silence.silent, silence.recovered)
    )
    for stream in SILENT:
        assert silent[stream]["state"] in ("silent", "waiting"), silent[stream]
        assert silent[stream]["reason"].startswith(("nothing has come for ", "no capture for "))
        assert recovered[stream]["state"] == "runs", recovered[stream]


def test_topics_tell_the_silence_and_the_recovery(silence: Silence) -> None:
    silent, recovered = (
        [it for it in json.loads(outputs["topics"].stdout) if it["stream"] in SILENT]
        for outputs in (silence.silent, silence.recovered)
    )
    assert {it["stream"] for it in silent} == set(SILENT)
    assert {it["stream_state"] for it in silent} <= {"silent", "waiting"}
    assert {it["stream_state"] for it in recovered} == {"running"}


def test_doctor_tells_the_silence_and_the_recovery(silence: Silence) -> None:
    silent, recovered = (
        next(it for it in json.loads(outputs["doctor"].stdout) if it["check"] == "streams")
        for outputs in (silence.silent, silence.recovered)
    )
    assert (silence.silent["doctor"].returncode, silent["level"]) == (1, "wrong")
    assert all(f"{stream}: " in silent["found"] for stream in SILENT), silent
    assert recovered["level"] == "ok", recovered
