"""`ml2-receiver view` beside a receiver with a headset."""

import os
import socket
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import bag_scene
from configurations import only
from ml2_receiver.configuration.config import load_config
from ml2_receiver.pairing.uri import PairingUri
from ml2_receiver.security.paired_devices import PairedDevices
from mock_device import MockDevice
from repeated import begin, connected, repeated
from ros_processes import Child, Client, Receiver
from test_command_pair import Device
from test_pairing_listener import PAIRED
from viewing_browser import Browser, Picture, View

pytest.importorskip("rclpy", reason="rclpy is not installed")

from ml2_tools.live.diagnostics_node import DiagnosticsNode
from waiting import LIMIT_S

CONFIG = only(
    """
    world_left: {enabled: true},
    depth_center: {enabled: true, format: depth16},
    eye_nasal_left: {enabled: true},
    battery: {enabled: true}
    """
)
WATCHED = "watched"
WORLD = f"/{WATCHED}/magic_leap2/world_left/image_raw"
EYE = f"/{WATCHED}/magic_leap2/eye_nasal_left/image_raw"


def depth(number: int) -> bytes:
    """Random distances from 4.5 m to 5 m."""
    return bag_scene.depth_of(4500 + bag_scene.millimetres(number) // 10, number)


MADE = {
    "world_left/image_raw": bag_scene.image,
    "depth/image_raw/compressedDepth": depth,
    "eye_nasal_left/image_raw": bag_scene.image,
    "battery": bag_scene.battery,
}


@pytest.fixture
def receiver(config: Path) -> Iterator[Receiver]:
    with Receiver(config, "--insecure-eye-images") as receiver:
        yield receiver


@pytest.fixture
def view(device: MockDevice) -> Iterator[View]:
    with View() as view:
        yield view


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory) -> Iterator[View]:
    """A page of changing images, for the tests that change nothing themselves.

    Its receiver has a name. Without one, the requests of other tests would reach it, too.
    """
    config = tmp_path_factory.mktemp("watched") / "config.yaml"
    config.write_text(CONFIG)
    with (
        Receiver(config, "--name", WATCHED, "--insecure-eye-images") as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        begin(device)
        with publishing(device), View("--name", WATCHED) as view:
            yield view


def publishing(device: MockDevice) -> AbstractContextManager[None]:
    """Each image differs from the one before."""
    numbers = count()

    def publish() -> None:
        number = next(numbers)
        for topic, make in MADE.items():
            device.publish(topic, make(number))

    return repeated(connected(device, publish), 0.05)


def test_a_browser_sees_the_state_and_images_that_change(watched: View) -> None:
    with Browser(watched.url, watched.token) as browser:
        assert [it["name"] for it in browser.text("hello")["plots"]][:2] == [
            "gyroscope",
            "accelerometer",
        ]
        browser.say(show=["world_left"])
        first, second = browser.picture(), browser.picture()
        assert first.stream == second.stream == "world_left"
        assert first.pixels.shape == (48, 64)
        assert first.pixels.std() > 20
        assert np.abs(first.pixels.astype(int) - second.pixels).mean() > 20
        state = browser.text("state")
        while {it["name"]: it["text"] for it in state["facts"]}["battery"] != "50 %":
            state = browser.text("state")
        streams = {it["id"]: it for it in state["streams"]}
        while not streams["world_left"]["mode"] or streams["world_left"]["latency_p50_ms"] is None:
            streams = {it["id"]: it for it in browser.text("state")["streams"]}
    assert list(streams) == ["depth", "world_left", "eye_nasal_left"]
    assert streams["world_left"]["mode"] == "1016x1016@30 Grayscale"
    assert streams["world_left"]["topic"] == WORLD
    assert streams["world_left"]["latency_p50_ms"] is not None
    facts = {it["name"]: it["text"] for it in state["facts"]}
    assert facts["headset"] == "device name, connected"
    assert facts["security"].startswith("insecure")


def test_it_gives_way_to_the_receiver(watched: View) -> None:
    own = os.getpriority(os.PRIO_PROCESS, 0)
    assert os.getpriority(os.PRIO_PROCESS, watched.process.pid) == min(own + 5, 19)
    assert os.sched_getscheduler(watched.process.pid) == os.SCHED_BATCH


def test_depth_comes_in_colours_with_a_scale(watched: View) -> None:
    with Browser(watched.url, watched.token) as browser:
        browser.say(show=["depth"])
        found = browser.picture()
    assert (found.stream, found.far_m) == ("depth", 5)
    assert found.pixels.shape == (6, 8, 3)
    assert found.pixels.std(axis=2).max() > 20


def test_samples_come_while_messages_do(watched: View) -> None:
    with Browser(watched.url, watched.token) as browser:
        while "received" not in (samples := browser.text("samples"))["plots"]:
            pass
    ((time_s, (mbit_per_s,)), *_) = samples["plots"]["received"]
    assert abs(time_s - samples["now_s"]) < 60
    assert mbit_per_s >= 0


def test_a_browser_that_acknowledges_nothing_gets_two_images_and_delays_nobody(
    device: MockDevice, view: View
) -> None:
    with (
        publishing(device),
        Browser(view.url, view.token) as stalled,
        Browser(view.url, view.token) as other,
    ):
        for browser in (stalled, other):
            browser.say(show=["world_left"])
        found: list[object] = []
        while sum(isinstance(it, Picture) for it in found) < 2:
            found.append(stalled.next(acknowledges=False))
        for _ in range(10):
            other.picture()
        assert not any(isinstance(it, Picture) for it in stalled.sent())
        stalled.say(seen="world_left")
        while not isinstance(stalled.next(acknowledges=False), Picture):
            pass


def test_a_change_is_shown_as_it_is_in_force(
    device: MockDevice, view: View, client: Client
) -> None:
    with Browser(view.url, view.token) as browser, Browser(view.url, view.token) as other:
        assert browser.text("settings")["sections"]["battery"] == {"enabled": True}
        browser.say(set="battery", to={"enabled": False})
        # The values in force come first: with the answer, the page shows them.
        assert browser.text("settings")["sections"]["battery"] == {"enabled": False}
        assert browser.text("answer") == answer("battery", True, "")
        while other.text("settings")["sections"]["battery"] != {"enabled": False}:
            pass
        # Another program changes it, too.
        assert client.ask("set", {"battery.enabled": True}) == [[True, ""]]
        assert browser.text("settings")["sections"]["battery"] == {"enabled": True}


def test_a_refused_change_says_why_and_changes_nothing(device: MockDevice, view: View) -> None:
    with Browser(view.url, view.token) as browser:
        before = browser.text("settings")["sections"]["depth_center"]
        assert (before["stream"], before["mode"]) == (1, "544x480@30")
        browser.say(set="depth_center", to={"stream": 0, "mode": "544x480@30"})
        refusal = browser.text("answer")
        assert refusal["is_done"] is False
        assert "update_rate" in refusal["text"]
        browser.say(set="battery", to={"enabled": False})
        assert browser.text("settings")["sections"]["depth_center"] == before


def test_services_are_called(device: MockDevice, view: View) -> None:
    with Browser(view.url, view.token) as browser:
        browser.say(call="stop_recording")
        assert browser.text("answer") == answer("stop_recording", False, "no recording is on")
        browser.say(call="stop")
        assert browser.text("answer")["is_done"] is True
        while browser.text("state")["applied"].get("battery") != "paused":
            pass


def test_what_was_changed_on_the_page_is_saved_and_nothing_else(
    device: MockDevice, view: View, client: Client, config: Path
) -> None:
    assert client.ask("set", {"tf.layout": "rig"}) == [[True, ""]]
    with Browser(view.url, view.token) as browser:
        browser.say(set="battery", to={"enabled": False})
        assert browser.text("answer") == answer("battery", True, "")
        browser.say(call="save_config", keys=["battery.enabled"])
        assert browser.text("answer") == answer("save_config", True, f"written to {config}")
        browser.say(call="save_config")
        assert "not as in the file are tf.layout" in browser.text("answer")["text"]
    values = load_config(config).values
    assert (values["battery.enabled"], values["tf.layout"]) == (False, "flat")


def test_a_headset_is_paired_on_the_page(
    device: MockDevice, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    keys = tmp_path / "keys"
    with View("--keys", str(keys), "--receiver-port", "4711") as view:
        with Browser(view.url, view.token) as browser:
            began_s = time.monotonic()
            browser.say(pair=True)
            news = browser.text("pairing")
            assert 299 - (time.monotonic() - began_s) < news["left_s"] <= 300
            assert code_of(news["modules"]) == news["uri"]
            uri = PairingUri.parse(news["uri"])
            # Each address of this machine leads to the same listener.
            own = Device(tmp_path, replace(uri, host="127.0.0.1"))
            assert own.pair() == (PAIRED, {"name": socket.gethostname(), "port": 4711})
            assert browser.text("pairing") == {
                "type": "pairing",
                "is_done": True,
                "text": "paired with Magic Leap 2",
            }
        (paired,) = PairedDevices(keys).load()
        assert paired.fingerprint == own.certificate.fingerprint
        said = " ".join(view.errors)
    assert uri.token not in said + capfd.readouterr().err


def test_a_pairing_ends_with_the_page_that_began_it(device: MockDevice, tmp_path: Path) -> None:
    with View("--keys", str(tmp_path / "keys")) as view:
        with Browser(view.url, view.token) as browser, Browser(view.url, view.token) as other:
            browser.say(pair=True)
            first = browser.text("pairing")["uri"]
            browser.say(pair=False)
            assert browser.text("pairing") == {"type": "pairing", "is_done": False, "text": ""}
            other.say(pair=True)
            while (second := other.text("pairing").get("uri")) in (None, first):
                pass
        for uri in map(PairingUri.parse, (first, second)):
            await_refused(uri.port)


def code_of(modules: list[str]) -> str:
    """The text of a QR code, as OpenCV reads it."""
    white = np.array([[it == "0" for it in row] for row in modules], np.uint8) * 255
    text, _, _ = cv2.QRCodeDetectorAruco().detectAndDecode(white.repeat(8, 0).repeat(8, 1))
    return text


def await_refused(port: int) -> None:
    """Waits until nobody listens on a port; the test's time limit ends an endless wait."""
    with suppress(ConnectionRefusedError):
        while True:
            # Reset if it is accepted by nobody before the port is closed
            with suppress(ConnectionResetError):
                socket.create_connection(("127.0.0.1", port), LIMIT_S).close()


def answer(to: str, is_done: bool, text: str) -> dict[str, Any]:
    return {"type": "answer", "to": to, "is_done": is_done, "text": text}


@pytest.mark.usefixtures("ros_of_children")
def test_it_subscribes_to_an_image_only_while_a_browser_shows_it(watched: View) -> None:
    node = DiagnosticsNode()

    def await_subscribers(number: int) -> None:
        wanted = str(number)
        rows = node.rows(
            WATCHED, LIMIT_S, lambda it: it.get(WORLD, {}).get("subscribers") == wanted
        )
        assert rows[EYE]["subscribers"] == "0"

    try:
        with (
            Browser(watched.url, watched.token) as first,
            Browser(watched.url, watched.token) as second,
        ):
            await_subscribers(0)
            first.say(show=["world_left"])
            second.say(show=["world_left", "depth"])
            await_subscribers(1)
            first.say(show=[])
            assert first.connection.ping().wait(LIMIT_S)
            await_subscribers(1)
        await_subscribers(0)
    finally:
        node.close()


def test_eye_images_need_the_option(watched: View) -> None:
    with Browser(watched.url, watched.token) as browser:
        assert "eye_nasal_left" not in browser.text("hello")["images"]
        (eye,) = [it for it in browser.text("state")["streams"] if it["is_eye"]]
        assert eye["id"] == "eye_nasal_left"
        browser.say(show=["eye_nasal_left"])
        assert browser.end()[0] == 1008


def test_with_the_option_eye_images_come_when_they_are_asked_for(device: MockDevice) -> None:
    with View("--eyes") as view, publishing(device), Browser(view.url, view.token) as browser:
        assert "eye_nasal_left" in browser.text("hello")["images"]
        browser.say(show=["eye_nasal_left"])
        assert browser.picture().stream == "eye_nasal_left"


def test_it_ends_with_an_interrupt_and_closes_the_page(view: View) -> None:
    with Browser(view.url, view.token) as browser:
        browser.text("hello")
        assert view.end() == 0
        assert browser.end()[0] == 1001


def test_run_starts_the_page_and_ends_it(config: Path) -> None:
    with Receiver(config, "--name", "robot1", "--view") as receiver:
        while not (line := receiver.line()).startswith("open http"):
            pass
        url, token = line.removeprefix("open ").split("/#")
        with Browser(url, token) as browser:
            assert browser.text("state")["facts"]
            assert receiver.end() == 0
            assert browser.end()[0] == 1001


# A browser that prints its words, and the mode and the content of the file that they name.
BROWSER = """
echo "$*"
stat --format %a "${1#file://}"
cat "${1#file://}"
echo
"""


def test_other_users_cannot_read_the_secret_in_the_words_of_the_browser(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = tmp_path / "browser"
    browser.write_text(BROWSER)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("BROWSER", f"sh {browser} %s")
    monkeypatch.setenv("HOME", str(tmp_path))
    with Child("-m", "ml2_receiver", "view", str(bag)) as view:
        address = view.line().removeprefix("open ")
        words, mode, content = (view.line() for _ in range(3))
        assert address.partition("#")[2] not in words
        assert mode == "600"
        assert f"0; url={address}" in content
        assert view.end() == 0
    assert list(tmp_path.glob("*.html")) == []


def test_without_a_file_for_the_browser_the_address_is_there(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("HOME", str(tmp_path / "none"))
    with Child("-m", "ml2_receiver", "view", str(bag)) as view:
        assert view.line().startswith("open http")
        view.await_error("no browser is started: ")
        assert view.end() == 0


def test_a_port_in_use_is_named_with_what_to_do(watched: View) -> None:
    port = watched.url.rpartition(":")[2]
    with Child("-m", "ml2_receiver", "view", "--no-browser", "--port", port) as other:
        assert other.wait() == 2
        error, hint = other.errors
    assert error.startswith(f"cannot listen on 127.0.0.1:{port}: the port is used by ")
    assert hint == "hint: Choose another port with --port, or leave it out."
