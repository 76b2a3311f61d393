"""Choosing the address at which headsets connect."""

import gc
import io
import sys
from argparse import Namespace
from contextlib import ExitStack
from pathlib import Path

import pytest

from configurations import only_config
from fake_sink import FakeGraph, FakeSink
from free_port import reserve_port
from ml2_receiver.commands import session_port
from ml2_receiver.commands.receiving import new_server, running
from ml2_receiver.commands.session_port import SessionPort
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.transport.listener import everywhere, text
from ml2_receiver.wire.messages import AllowedUses
from ml2_receiver.wire.opening_bodies import Open
from mock_device import MockDevice
from test_server import mark_of
from tls_device import Certificate
from waiting import await_true


@pytest.fixture(autouse=True)
def port(monkeypatch: pytest.MonkeyPatch) -> int:
    """One that is free instead of the usual one."""
    number = reserve_port()
    monkeypatch.setattr(session_port, "_LOOPBACK", ("127.0.0.1", number))
    monkeypatch.setattr(session_port, "_EVERYWHERE", everywhere(number))
    return number


def options(keys: Path, **others: object) -> Namespace:
    flags = dict.fromkeys(("insecure", "insecure_control", "insecure_eye_images"), False)
    return Namespace(keys=keys, **{"name": "", "listen": None, **flags, **others})


def listened_on(options: Namespace) -> tuple[str, int]:
    with SessionPort(options) as way_in:
        host, port = way_in.listener.getsockname()[:2]
        return host, port


def test_it_is_this_machine_only_while_nobody_is_paired(tmp_path: Path, port: int) -> None:
    assert listened_on(options(tmp_path)) == ("127.0.0.1", port)


def test_it_is_all_interfaces_once_somebody_is(tmp_path: Path, port: int) -> None:
    PairedDevices(tmp_path).add("a", "a", Certificate(tmp_path / "a", "a").der)
    assert listened_on(options(tmp_path)) == everywhere(port)


def test_without_tls_it_is_this_machine_only_whoever_is_paired(tmp_path: Path, port: int) -> None:
    PairedDevices(tmp_path).add("a", "a", Certificate(tmp_path / "a", "a").der)
    assert listened_on(options(tmp_path, insecure=True)) == ("127.0.0.1", port)


def test_what_the_user_chose_is_listened_on(tmp_path: Path) -> None:
    host, _ = listened_on(options(tmp_path, listen=("127.0.0.3", 0)))
    assert host == "127.0.0.3"


def test_without_tls_there_are_no_keys(tmp_path: Path) -> None:
    listened_on(options(tmp_path / "keys", insecure=True))
    assert not (tmp_path / "keys").exists()


@pytest.mark.parametrize("flags", [(False, False), (True, False), (True, True)])
def test_eye_images_are_withheld_in_the_clear_unless_allowed(
    tmp_path: Path, flags: tuple[bool, bool]
) -> None:
    insecure, insecure_eye_images = flags
    flagged = options(tmp_path, insecure=insecure, insecure_eye_images=insecure_eye_images)
    with SessionPort(flagged) as way_in:
        withheld = set(way_in.excluded)
    eyes = {f"eye_{place}_{side}" for place in ("nasal", "temple") for side in ("left", "right")}
    assert withheld == (eyes if flags == (True, False) else set())


def test_a_running_receiver_opens_to_the_network_with_the_first_paired_device(
    tmp_path: Path, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = io.StringIO()
    monkeypatch.setattr(sys, "stdout", said)
    config = only_config("battery: {enabled: true}")
    with SessionPort(options(tmp_path / "keys")) as way_in, ExitStack() as stack:
        server = new_server(way_in, config, FakeSink())
        stack.enter_context(running(server, way_in))
        assert server.address == f"127.0.0.1:{port}"
        certificate = Certificate(tmp_path / "a", "a")
        PairedDevices(tmp_path / "keys").add("a", "a", certificate.der)
        await_true(lambda: f"listening on {text(everywhere(port))}" in said.getvalue())
        with MockDevice(f"127.0.0.1:{port}", tls=certificate.context()) as device:
            device.connect()


def test_a_collection_while_it_runs_visits_nothing_that_was_loaded_before(tmp_path: Path) -> None:
    insecure = options(tmp_path, insecure=True, listen=("127.0.0.1", 0))
    with SessionPort(insecure) as port:
        server = new_server(port, only_config("battery: {enabled: true}"), FakeSink())
        with running(server, port):
            visited = {id(it) for it in gc.get_objects()}
            assert not visited & {id(sys.modules), id(server)}
    assert id(sys.modules) in {id(it) for it in gc.get_objects()}


def test_small_messages_of_ros_are_marked_urgent_and_large_ones_give_way(tmp_path: Path) -> None:
    with ExitStack() as stack:
        port = stack.enter_context(
            SessionPort(options(tmp_path, insecure=True, listen=("127.0.0.1", 0)))
        )
        server = new_server(port, only_config("app: {subscribe: ['/**']}"), FakeSink(), FakeGraph())
        stack.enter_context(running(server, port))
        app = stack.enter_context(MockDevice(server.address, has_ros=True))
        app.reach_configure()
        marks = {lane: mark_of(app.join(lane).socket) for lane in ("ros", "bulk_1", "bulk_4")}
    assert marks == {"ros": 48 << 2, "bulk_1": 8 << 2, "bulk_4": 8 << 2}


@pytest.mark.parametrize("has_control", [False, True])
def test_without_tls_apps_only_subscribe_unless_the_user_allows_control(
    has_control: bool, tmp_path: Path
) -> None:
    rules = "app: {subscribe: ['/**'], publish: ['/**'], call: ['/**'], offer: ['/**']}"
    insecure = options(
        tmp_path, insecure=True, insecure_control=has_control, listen=("127.0.0.1", 0)
    )
    with ExitStack() as stack:
        port = stack.enter_context(SessionPort(insecure))
        config = only_config(rules)
        server = new_server(port, config, FakeSink(), FakeGraph(config.app))
        stack.enter_context(running(server, port))
        app = stack.enter_context(MockDevice(server.address, has_ros=True))
        app.reach_configure()
        assert app.welcome.ros == AllowedUses(True, has_control, has_control, has_control)
        kinds = ("subscription", "client", "service")
        answers = [
            app.open(Open(id, kind, "/name", "T")).result for id, kind in enumerate(kinds, 1)
        ]
    allowed = "opened" if has_control else "refused"
    assert answers == ["opened", allowed, allowed]
