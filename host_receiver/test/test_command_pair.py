import json
import socket
import time
from contextlib import suppress
from pathlib import Path

import pytest

from command_line import refusal
from configurations import only
from ml2_receiver.cli import main
from ml2_receiver.pairing.uri import PairingUri
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.wire.kinds import Kind
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child
from terminal import OnTerminal
from test_pairing_listener import ERROR, PAIR, PAIRED, PairingScene, read, send
from tls_device import Certificate
from waiting import LIMIT_S

CONFIG = only("battery: {enabled: true}")


class Device(PairingScene):
    """Pairs with what a URI says."""

    def __init__(self, folder: Path, uri: PairingUri) -> None:
        self.address = uri.host, uri.port
        self.fingerprint = uri.fingerprint
        self.pairing = uri  # type: ignore[assignment]  # for its token
        self.certificate = Certificate(folder / "device", "device")


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    return tmp_path / "keys"


def pair_command(keys: Path, *options: str, listen: str = "127.0.0.1:0") -> Child:
    words = ("pair", "--keys", str(keys), "--listen", listen)
    return Child("-m", "ml2_receiver", *words, *options)


def paired(folder: Path, keys: Path) -> Device:
    with pair_command(keys, "--port", "4711", "--name", "desk") as pairing:
        device = Device(folder, PairingUri.parse(pairing.line()))
        assert device.pair() == (PAIRED, {"name": "desk", "port": 4711})
        assert pairing.line().startswith("paired with 'Magic Leap 2', fingerprint ")
        assert pairing.wait() == 0
    return device


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="this machine has no IPv6")
def test_a_device_is_paired_by_ipv6(tmp_path: Path, keys: Path) -> None:
    with pair_command(keys, listen="[::1]:0") as pairing:
        line = pairing.line()
        assert line.startswith("ml2s://[::1]:")
        assert Device(tmp_path, PairingUri.parse(line)).pair()[0] == PAIRED


def test_a_device_is_paired_listed_and_unpaired(
    tmp_path: Path, keys: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    device = paired(tmp_path, keys)
    assert main(["devices", "--paired", "--json", "--keys", str(keys)]) == 0
    (listed,) = json.loads(capsys.readouterr().out)
    assert listed["name"] == "Magic Leap 2"
    assert listed["fingerprint"] == device.certificate.fingerprint
    assert main(["devices", "--paired", "--keys", str(keys)]) == 0
    assert "Magic Leap 2" in capsys.readouterr().out
    assert main(["unpair", "Magic Leap 2", "--keys", str(keys)]) == 0
    assert main(["devices", "--paired", "--keys", str(keys)]) == 0
    assert "no device is paired: run `ml2-receiver pair`" in capsys.readouterr().out


def test_who_is_not_paired_cannot_be_unpaired(keys: Path) -> None:
    said = refusal("unpair", "nobody", "--keys", keys)
    assert said == "no paired device 'nobody'; paired: none\n"


def test_five_wrong_tokens_end_it(tmp_path: Path, keys: Path) -> None:
    with pair_command(keys) as pairing:
        device = Device(tmp_path, PairingUri.parse(pairing.line()))
        for _ in range(5):
            with device.connect() as tls:
                send(tls, PAIR, device.answer(read(tls)[1]["nonce"], token="0" * 32))
                assert read(tls)[0] == ERROR
        assert pairing.wait() == 2
    # Each wrong token is told by a thread of its own.
    told = ("wrong token, ", "more such events")
    error, hint = [it for it in pairing.errors if not any(words in it for words in told)][-2:]
    assert "too many wrong tokens" in error
    assert hint.startswith("hint: Somebody on the network may be guessing.")
    assert PairedDevices(keys).load() == []


def test_strangers_do_not_make_the_code_scroll_away(tmp_path: Path, keys: Path) -> None:
    with pair_command(keys) as pairing:
        device = Device(tmp_path, PairingUri.parse(pairing.line()))
        began_s = time.monotonic()
        for _ in range(50):
            with socket.create_connection(device.address, LIMIT_S) as other:
                other.sendall(b"GET / HTTP/1.1\r\n\r\n")
                with suppress(ConnectionError):
                    other.recv(100)
        took_s = time.monotonic() - began_s
        assert device.pair()[0] == PAIRED
        assert pairing.wait() == 0
    # The first stranger may come before how long the code is valid is said
    assert any("no TLS connection" in line for line in pairing.errors[:2])
    # Three lines of each second, and some of others
    assert len(pairing.errors) < min(50, 10 + 3 * took_s)


def test_a_folder_that_takes_nothing_is_named(tmp_path: Path, keys: Path) -> None:
    with pair_command(keys) as pairing:
        device = Device(tmp_path, PairingUri.parse(pairing.line()))
        (keys / "devices").write_text("in the way")
        assert device.pair()[0] == ERROR
        assert pairing.wait() == 2
    assert pairing.errors[-2].startswith("cannot use ")


def test_an_interrupt_pairs_nobody(keys: Path) -> None:
    with pair_command(keys) as pairing:
        pairing.line()
        assert pairing.end() == 2
    assert pairing.errors == ["valid for 5 minutes, for one device", "no headset was paired"]


def test_on_a_terminal_there_is_what_to_type_and_the_time_left(keys: Path) -> None:
    with OnTerminal("pair", "--keys", str(keys)) as pairing:
        shown = pairing.await_shown(rb"waiting for the headset, [45]:\d\d left")
    assert "▀".encode() in shown
    assert b"ml2-receiver headset start --pair -" in shown
    assert b"--pair 'ml2s://" not in shown


def test_a_running_receiver_lets_in_who_is_paired_and_ends_who_is_not_any_more(
    tmp_path: Path, keys: Path
) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    options = ("--no-ros", "--config", str(config), "--listen", "127.0.0.1:0", "--keys", str(keys))
    with Child("-m", "ml2_receiver", "record", str(tmp_path / "walk"), *options) as receiver:
        address = receiver.line().removeprefix("listening on ")
        device = paired(tmp_path, keys)
        with MockDevice(address, tls=device.certificate.context()) as headset:
            headset.start()
            headset.publish("battery")
            control = headset.wires["control"]

            def say_ping() -> None:
                with suppress(OSError):  # the session may just have ended
                    control.send(Kind.PING)

            # A slow machine takes longer to unpair it than a receiver waits for silent devices.
            with repeated(say_ping, 0.1):
                main(["unpair", "Magic Leap 2", "--keys", str(keys)])
                receiver.await_error("session ended: the device was unpaired")
            control.expect_end()
        assert receiver.end() == 0
    assert not any("WARNING" in line for line in receiver.errors)


def test_insecure_is_loud_and_asks_for_no_eye_images(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(f"{CONFIG}    eye_nasal_left: {{enabled: true}}\n")
    options = ("--no-ros", "--config", str(config), "--listen", "127.0.0.1:0", "--insecure")
    with Child("-m", "ml2_receiver", "record", str(tmp_path / "walk"), *options) as receiver:
        address = receiver.line().removeprefix("listening on ")
        with MockDevice(address) as headset:
            assert "eye_nasal_left" not in headset.reach_configure().streams
            headset.disconnect()
            headset.start()
        receiver.await_error("WARNING: --insecure: no encryption")
        receiver.await_error("eye_nasal_left refused: 'eye images are biometric: pair, or allow")
        assert receiver.end() == 0
    with Child(
        *("-m", "ml2_receiver", "record", str(tmp_path / "eyes"), *options),
        "--insecure-eye-images",
    ) as receiver:
        address = receiver.line().removeprefix("listening on ")
        with MockDevice(address) as headset:
            assert "eye_nasal_left" in headset.reach_configure().streams
