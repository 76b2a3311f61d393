"""Pairing, encryption and refusals between the headset's and the receiver's commands."""

from __future__ import annotations

import contextlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from configurations import only
from counters import have_arrived
from ml2_receiver.table.reader import load_table
from processes import (
    PLAINTEXT,
    PREFIX,
    RECEIVER,
    Security,
    ended,
    headset_command,
    isolated_environment,
    line_with,
    listening_address,
    paired,
    process,
    receive,
    receive_command,
    with_keys,
)
from proxy import Proxy
from simulation import STILL

CONFIG = only("world_center: {enabled: true}, eye_nasal_left: {enabled: true}")
IMAGE = "world_center/image_raw"
EYE = "eye_nasal_left/image_raw"
CHUNK_PIXELS = 32
# Shorter words occur by chance: in 100 MB of random bytes, a word of 4 letters in 2 of 100 runs,
# one of 6 letters in 4 of ten million.
MIN_WORD_LENGTH = 6
TOPICS = {topic.name for stream in load_table().streams.values() for topic in stream.topics}
WORDS_ON_THE_WIRE = {"ticket", "session", "sensor_msgs", IMAGE, EYE}


@pytest.fixture
def config(tmp_path: Path) -> Path:
    file = tmp_path / "config.yaml"
    file.write_text(CONFIG)
    return file


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The keys of a receiver and a headset that are paired."""
    folder = tmp_path_factory.mktemp("keys")
    paired(folder)
    return folder


@pytest.fixture
def security(keys: Path, tmp_path: Path) -> Security:
    """The options of a paired receiver and headset, whose keys nobody else has."""
    return with_keys(shutil.copytree(keys, tmp_path / "keys"))


@pytest.mark.parametrize("is_encrypted", [True, False])
def test_a_listener_between_them_reads_nothing_unless_both_are_insecure(
    config: Path, security: Security, tmp_path: Path, is_encrypted: bool
) -> None:
    proxies = []

    def capturing(address: str) -> Proxy:
        proxies.append(Proxy(address, captures=True))
        return proxies[0]

    used = security if is_encrypted else PLAINTEXT
    enough = have_arrived({IMAGE: 3, EYE: 1})
    received = receive(config, [*STILL], tmp_path, capturing, security=used, is_enough=enough)
    images = received.messages(IMAGE)
    assert images
    assert received.messages(EYE), "eye images are not withheld"
    captured = bytes(proxies[0].captured)
    assert len(captured) > sum(len(image.data) for image in images)
    rows = [
        row[:CHUNK_PIXELS].tobytes()
        for image in images[:3]
        for row in np.frombuffer(image.data, np.uint8).reshape(image.height, -1)[::50]
    ]
    searched = {word for word in TOPICS | WORDS_ON_THE_WIRE if len(word) >= MIN_WORD_LENGTH}
    words = {word for word in searched if word.encode() in captured}
    seen = [row for row in rows if row in captured]
    if is_encrypted:
        assert (words, seen) == (set(), [])
    else:
        assert words >= WORDS_ON_THE_WIRE
        assert len(seen) > 0.9 * len(rows), "data of another lane may be in the middle of a row"


def test_a_headset_sends_no_eye_images_in_plaintext_even_if_the_receiver_allows_it(
    config: Path, tmp_path: Path
) -> None:
    security = Security(PLAINTEXT.receiver, ("--insecure",))
    enough = have_arrived({IMAGE: 1})
    received = receive(config, [*STILL], tmp_path, security=security, is_enough=enough)
    assert received.messages(IMAGE)
    assert f"{PREFIX}/{EYE}" not in received.topics
    assert "eye_nasal_left refused: 'eye images are" in (tmp_path / "receiver.log").read_text()


def test_another_receiver_at_the_address_is_refused_with_a_message(
    config: Path, security: Security, tmp_path: Path
) -> None:
    environment = isolated_environment()
    with contextlib.ExitStack() as stack:
        run = receive_command(config, "127.0.0.1:0", security=security)
        with process(run, environment, tmp_path / "receiver.log") as receiver:
            address = listening_address(receiver)
            send = headset_command(address, security=security)
            headset = stack.enter_context(process(send, environment, tmp_path / "headset.log"))
            line_with(headset, "connected to")
        other_keys = Security(("--keys", tmp_path / "other"), ())
        run = receive_command(config, address, security=other_keys)
        stack.enter_context(process(run, environment, tmp_path / "other.log"))
        line_with(headset, "is not the one this headset is paired with")


def test_a_headset_that_is_not_paired_is_refused_with_a_message(
    config: Path, security: Security, tmp_path: Path
) -> None:
    environment = isolated_environment()
    unpair = [RECEIVER, "unpair", *security.receiver]
    list_paired = [RECEIVER, "devices", "--paired", "--json", *security.receiver]
    run = receive_command(config, "127.0.0.1:0", security=security)
    with process(run, environment, tmp_path / "receiver.log") as receiver:
        send = headset_command(listening_address(receiver), security=security)
        (device,) = json.loads(ended(list_paired).stdout)
        ended([*unpair, device["name"]]).check_returncode()
        with process(send, environment, tmp_path / "headset.log") as headset:
            line_with(headset, "not paired")
    assert "pairing: it is not paired" in (tmp_path / "receiver.log").read_text()
