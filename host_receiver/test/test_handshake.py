import dataclasses

import pytest

from ml2_receiver.session.actions import Ending
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Bye, Configure
from scene import REQUEST, Scene, data, hello, started


def test_hello_is_welcomed_with_a_ticket_for_every_lane() -> None:
    scene = Scene()
    scene.begin()
    tickets = scene.welcome.tickets
    assert set(tickets) == {"time", "sensors", "link_test", *load_table().lanes}
    values = [scene.welcome.session, *tickets.values()]
    assert len(set(values)) == len(values)
    assert all(len(value) == 32 and int(value, 16) >= 0 for value in values)
    assert scene.welcome.received is None
    assert (scene.welcome.version, scene.welcome.name) == (1, "host")


def test_the_common_version_is_enough() -> None:
    scene = Scene()
    scene.begin(hello(versions=(3, 1, 2)))


def test_a_device_of_another_version_is_told_of_once_a_minute() -> None:
    scene = Scene()
    for _ in range(130):
        scene.pass_time(1.0)
        assert scene.error(scene.greet(hello(versions=(2, 3)))) == "version"
    told = [event for event in scene.sink.events if "version" in event]
    text = "address: version: this receiver speaks 1, not [2, 3]"
    assert told == [text, f"{text}, 59 more times", text, f"{text}, 59 more times", text]


def test_another_device_is_busy_and_the_first_goes_on() -> None:
    scene = started()
    assert scene.error(scene.greet(hello("b"))) == "busy"
    assert scene.is_connected()
    assert scene.ending(scene.control) is None


def test_who_comes_again_and_again_while_another_is_connected_is_logged_once() -> None:
    scene = started()
    for _ in range(30):
        scene.now_s += 1
        assert scene.error(scene.greet(hello("b"))) == "busy"
    busy = [event for event in scene.sink.events if "busy" in event]
    assert busy == ["address: busy: 'a name' is connected"]
    scene.end(scene.control)
    for lane in scene.lanes.values():
        scene.end(lane)
    busy = [event for event in scene.sink.events if "busy" in event]
    assert busy[1:] == [f"{busy[0]}, 29 more times"]


def test_the_same_device_takes_its_place_once_every_old_lane_is_read() -> None:
    scene = started()
    scene.receive_data("world_left", 1)
    old_control, old_lanes = scene.control, scene.lanes
    new_control = scene.greet()
    assert scene.sent(old_control)[-1] == (Kind.BYE, Bye("replaced"))
    assert {scene.ending(lane) for lane in old_lanes.values()} == {Ending.DRAIN}
    for connection in (old_control, old_lanes["time"], old_lanes["sensors"]):
        scene.end(connection)
        assert scene.kinds(new_control) == []
    old_lanes["world_left"].routes[1].receive(data(1, 1), 0, 0)
    scene.end(old_lanes["world_left"])
    scene.control = new_control
    scene.take_welcome()
    assert scene.welcome.received is not None
    assert scene.welcome.received["world_left/image_raw"] == 2
    assert scene.welcome.received["/tf"] == 0


def test_counts_of_another_instance_are_not_known() -> None:
    scene = started()
    control, lanes = scene.control, scene.lanes
    scene.control = scene.greet(hello(instance_id="2"))
    for connection in (control, *lanes.values()):
        scene.end(connection)
    scene.take_welcome()
    assert scene.welcome.received is None


def test_while_one_takes_over_no_other_may() -> None:
    scene = started()
    successor = scene.greet()
    assert scene.error(scene.greet()) == "busy"
    assert scene.error(scene.greet(hello("b"))) == "busy"
    scene.end(successor)
    for connection in (scene.control, *scene.lanes.values()):
        scene.end(connection)
    assert scene.kinds(successor) == []
    scene.begin(hello("b"))


@pytest.mark.parametrize(
    "wrong",
    [
        {"session": "0" * 32},
        {"ticket": "0" * 32},
        {"ticket": "\u00e9"},
        {"lane": "nose"},
        {"lane": "control"},
    ],
)
def test_a_refused_join_ends_itself_only_and_leaves_the_ticket(wrong: dict[str, str]) -> None:
    scene = Scene()
    scene.begin()
    assert scene.error(scene.join(**({"lane": "sensors"} | wrong))) == "ticket"
    assert scene.kinds(scene.join("sensors")) == [Kind.JOINED]


def test_nothing_can_be_joined_without_a_session() -> None:
    scene = Scene()
    scene.begin()
    scene.end(scene.control)
    assert scene.error(scene.join("sensors")) == "ticket"


def test_the_configuration_is_asked_for_when_time_and_sensors_are_joined() -> None:
    scene = Scene()
    scene.begin()
    scene.join("world_left")
    scene.join("sensors")
    assert Kind.CONFIGURE not in scene.kinds(scene.control)
    scene.join("time")
    scene.join("depth")
    configures = [body for kind, body in scene.sent(scene.control) if kind == Kind.CONFIGURE]
    assert configures == [Configure(1, REQUEST)]


def test_silence_instead_of_a_greeting_times_out() -> None:
    scene = Scene()
    silent = scene.connect()
    scene.pass_time(4.9)
    assert scene.ending(silent) is None
    scene.pass_time(0.2)
    assert scene.error(silent) == "timeout"


def test_for_the_seventeenth_stranger_the_oldest_goes_of_the_machine_with_most() -> None:
    scene = started()
    quiet = scene.connect("quiet")
    flood = [scene.connect("flood") for _ in range(15)]
    late = scene.connect("late")
    assert scene.ending(flood[0]) is Ending.ABORT
    assert [scene.ending(it) for it in (quiet, *flood[1:], late)] == [None] * 16
    assert scene.is_connected()


def test_refusals_are_logged_at_most_ten_times_a_second() -> None:
    scene = Scene()
    for _ in range(25):
        scene.end(scene.connect(), "broken")
    assert len(scene.sink.events) == 10
    scene.now_s += 1
    scene.end(scene.connect())
    assert scene.sink.events[10:] == [
        "15 more such events",
        "address:1 (new connection): ended without HELLO or JOIN",
    ]


def test_what_a_device_writes_is_one_short_line_of_the_log() -> None:
    scene = Scene()
    for key in ("\n\x1b[2Jforged", "n" * 60_000, "\n" * 10_000):
        wrong = dataclasses.replace(hello(), permissions={key: 1})  # type: ignore[dict-item]
        scene.end(scene.greet(wrong))
    assert any("forged: expected bool" in event for event in scene.sink.events)
    for event in scene.sink.events:
        assert event.isprintable()
        assert len(event) <= 1000


def test_the_receiver_says_goodbye_when_it_stops() -> None:
    scene = started()
    connection = scene.connect()
    scene.host.stop()
    scene.perform()
    assert scene.sent(scene.control)[-1] == (Kind.BYE, Bye("the receiver stops"))
    assert scene.ending(scene.control) is Ending.DISCARD
    assert scene.ending(scene.lanes["sensors"]) is Ending.DRAIN
    assert scene.ending(connection) is Ending.ABORT
