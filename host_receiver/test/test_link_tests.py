"""The receiver's side of the link test; time is what a test says."""

import pytest

from ml2_receiver.errors import LinkTestError
from ml2_receiver.session.link_tests import LinkTestResult
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import MAX_LINK_TEST_BYTES, Bye, LinkTest
from scene import Scene, started

WHOLE = bytes(64 * 1024)


@pytest.fixture
def scene() -> Scene:
    scene = started()
    scene.join("link_test")
    return scene


def fill(scene: Scene, body: bytes) -> None:
    scene.receive(scene.lanes["link_test"], Kind.FILLER, body)


def measured(scene: Scene) -> LinkTestResult:
    found = scene.report().link_test
    assert found is not None
    return found


def test_filler_is_timed_from_the_first_frame_to_the_end(scene: Scene) -> None:
    scene.test_link()
    assert scene.sent(scene.control)[-1] == (Kind.LINK_TEST, LinkTest(64 << 20))
    scene.pass_time(1.0)  # until the lane is joined and the first frame is here
    fill(scene, WHOLE)
    for _ in range(4):
        scene.pass_time(0.1)
        fill(scene, WHOLE)
    scene.pass_time(0.1)
    assert measured(scene).state == "running"
    fill(scene, b"")
    found = measured(scene)
    assert (found.state, found.number, found.filler_bytes) == ("measured", 1, 5 * len(WHOLE))
    assert found.duration_s == pytest.approx(0.5)
    assert found.free_mbit_per_s == pytest.approx(4 * len(WHOLE) * 8e-6 / 0.5)
    assert found.streams_mbit_per_s == 0


def test_what_the_streams_get_meanwhile_is_told_and_no_filler_is_in_their_books(
    scene: Scene,
) -> None:
    scene.receive_data("world_left", 1, 0)
    scene.test_link()
    fill(scene, WHOLE)
    for sequence in range(1, 4):
        scene.receive_data("world_left", 1, sequence)
    scene.pass_time(1.0)
    fill(scene, b"")
    scene.receive_data("world_left", 1, 4)
    assert measured(scene).streams_mbit_per_s == pytest.approx(3 * 8 * 8e-6)
    (row,) = [it for it in scene.report().topics if it.statistics.received]
    assert (row.statistics.received, row.statistics.gaps) == (5, 0)


def test_an_end_without_filler_is_no_rate(scene: Scene) -> None:
    scene.test_link()
    fill(scene, b"")
    assert measured(scene) == LinkTestResult(1, "measured")


def test_tests_follow_on_each_other_but_not_at_once(scene: Scene) -> None:
    scene.test_link()
    with pytest.raises(LinkTestError, match="already"):
        scene.test_link()
    fill(scene, b"")
    scene.test_link()
    assert (measured(scene).number, measured(scene).state) == (2, "running")
    assert scene.kinds(scene.control).count(Kind.LINK_TEST) == 2


def test_a_headset_that_does_not_answer_is_not_asked_again(scene: Scene) -> None:
    scene.test_link()
    for _ in range(9):
        scene.pass_time(1.0)
        scene.receive(scene.control, Kind.PONG)
    assert measured(scene).state == "unanswered"
    with pytest.raises(LinkTestError, match="does not answer"):
        scene.test_link()
    assert scene.is_connected()
    fill(scene, WHOLE)
    scene.pass_time(1.0)
    fill(scene, b"")
    assert measured(scene).state == "measured"
    scene.test_link()


def test_as_much_as_was_asked_for_may_come_and_nothing_more(scene: Scene) -> None:
    scene.test_link()
    for _ in range(MAX_LINK_TEST_BYTES // len(WHOLE)):
        fill(scene, WHOLE)
    assert scene.is_connected()
    fill(scene, b"x")
    assert scene.error(scene.lanes["link_test"]) == "unexpected"
    assert not scene.is_connected()


@pytest.mark.parametrize("body", [b"", WHOLE])
def test_filler_that_was_not_asked_for_is_unexpected(scene: Scene, body: bytes) -> None:
    fill(scene, body)
    assert scene.error(scene.lanes["link_test"]) == "unexpected"


@pytest.mark.parametrize("body", [b"", WHOLE])
def test_a_test_that_has_ended_takes_nothing_more(scene: Scene, body: bytes) -> None:
    scene.test_link()
    fill(scene, b"")
    fill(scene, body)
    assert scene.error(scene.lanes["link_test"]) == "unexpected"


def test_without_a_headset_there_is_nothing_to_try() -> None:
    scene = Scene()
    with pytest.raises(LinkTestError, match="no headset"):
        scene.test_link()
    scene.begin()
    with pytest.raises(LinkTestError, match="no headset"):
        scene.test_link()


def test_a_session_that_is_over_is_not_asked(scene: Scene) -> None:
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    for connection in (*scene.lanes.values(), scene.control):
        scene.end(connection)
    with pytest.raises(LinkTestError, match="no headset"):
        scene.test_link()
