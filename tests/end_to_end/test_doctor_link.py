"""`ml2-receiver doctor` measures the link to a headset that streams."""

from __future__ import annotations

import contextlib
import json
from typing import Any

import pytest

from configurations import only
from counters import assert_counters_agree
from processes import Received, headset_command
from proxy import Proxy
from simulation import STILL
from waiting_receiver import WaitingReceiver, waiting_receiver

# One raw camera at 30 Hz, which is 248 Mbit/s, and small streams.
CONFIG = only("world_left: {enabled: true}, other_sensors: {enabled: true}")
NEEDED_MBIT_PER_S = (240, 270)
SLOW_BYTES_PER_S = 10e6
LIMITS = (None, SLOW_BYTES_PER_S)

type Links = dict[float | None, dict[str, Any]]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Links, Received]:
    """Doctor's findings on a link with each limit, and all messages of that time."""
    folder = tmp_path_factory.mktemp("doctor")
    config = folder / "config.yaml"
    config.write_text(CONFIG)
    with contextlib.ExitStack() as stack:
        waiting = stack.enter_context(waiting_receiver(config, folder))
        proxy = stack.enter_context(Proxy(waiting.address))
        command = headset_command(proxy.address, *STILL)
        headset = stack.enter_context(waiting.started("headset", command))
        waiting.await_reading(after_s=0.0)
        found: Links = {}
        for bytes_per_s in LIMITS:
            proxy.limit(bytes_per_s)
            found[bytes_per_s] = doctor(waiting)
        headset.terminate()
        return found, waiting.result()


def doctor(waiting: WaitingReceiver) -> dict[str, Any]:
    """Runs doctor and returns its finding on the link."""
    run = waiting.run("doctor", "--json")
    (link,) = [it for it in json.loads(run.stdout) if it["check"] == "link to headset"]
    assert isinstance(link, dict)
    return link


@pytest.mark.parametrize("bytes_per_s", LIMITS)
def test_doctor_measures_the_link_and_every_lost_message_is_counted(
    measured: tuple[Links, Received], bytes_per_s: float | None
) -> None:
    links, received = measured
    assert_counters_agree(received)
    link = links[bytes_per_s]
    numbers = link["numbers"]
    free, streams = numbers["free_mbit_per_s"], numbers["streams_mbit_per_s"]
    least, most = NEEDED_MBIT_PER_S
    assert numbers["filler_bytes"] > 1 << 20
    assert free > 0
    assert streams > 0
    assert least < numbers["needed_mbit_per_s"] < most
    assert f"{free:.1f} Mbit/s were free besides {streams:.1f} of the streams" in link["found"]
    if bytes_per_s is not None:
        assert free + streams < least
        assert link["level"] == "hint"
        assert link["fix"].startswith("run `ml2-receiver set world_left.format=jpeg`: ")
