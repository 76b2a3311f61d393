"""Parts of a recording are read by its index, and are those that a full reading finds."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import recorded_room
from ml2_receiver.errors import RecordingError
from ml2_tools.bags.bounded_file import BoundedFile
from ml2_tools.bags.indexed_bag import History, IndexedBag
from recorded_room import BATTERY, BEGIN_NS, EYE, HZ, STATIC, WORLD, Recorded, time_ns

ALL = list(recorded_room.messages())
END_NS = ALL[-1].time_ns
times_ns = st.integers(BEGIN_NS - 10**9, END_NS + 10**9)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_room.write(tmp_path_factory.mktemp("bags") / "room")


@pytest.fixture(scope="module")
def bag(room: Path) -> IndexedBag:
    return IndexedBag(room)


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory: pytest.TempPathFactory) -> IndexedBag:
    return IndexedBag(
        recorded_room.write(tmp_path_factory.mktemp("bags") / "room", is_finished=False)
    )


def found(bag: IndexedBag, time_ns: int, topic: str, history: History) -> list[Recorded]:
    return [Recorded(*vars(it).values()) for it in bag.until(time_ns, {topic: history})]


def before(time_ns: int, topic: str) -> list[Recorded]:
    return [it for it in ALL if it.topic == topic and it.time_ns <= time_ns]


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(times_ns, st.sampled_from([WORLD, EYE, BATTERY, STATIC]), st.integers(1, 30))
def test_the_newest_messages_up_to_a_time_are_found(
    bag: IndexedBag, time_ns: int, topic: str, depth: int
) -> None:
    expected = before(time_ns, topic)
    assert found(bag, time_ns, topic, History(depth, None)) == expected[-depth:]
    assert found(bag, time_ns, topic, History(1, 0)) == expected[-1:]


def test_chunks_before_the_lead_are_not_read(bag: IndexedBag) -> None:
    assert HZ < len(found(bag, time_ns(150), WORLD, History(100, 10**9))) < 2 * HZ


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(times_ns)
def test_the_messages_after_a_time_are_read(bag: IndexedBag, time_ns: int) -> None:
    read = [Recorded(*vars(it).values()) for it in bag.after(time_ns)]
    assert read == [it for it in ALL if it.time_ns > time_ns]


def test_a_seek_reads_little(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag = IndexedBag(room)
    read: list[int] = []
    of_file = BoundedFile.read

    def counting(self: BoundedFile, size: int | None = -1, /) -> bytes:
        data = of_file(self, size)
        read.append(len(data))
        return data

    monkeypatch.setattr(BoundedFile, "read", counting)
    wanted = {WORLD: History(1, 0), EYE: History(1, 0), STATIC: History(100, None)}
    assert len(bag.until(time_ns(150), wanted)) == 3
    assert 0 < sum(read) < bag.size_bytes / 10


def test_times_and_counts_are_those_of_the_messages(bag: IndexedBag) -> None:
    assert (bag.begin_ns, bag.end_ns) == (BEGIN_NS, END_NS)
    assert bag.counts[WORLD] == len(before(END_NS, WORLD))
    assert bag.prefix == recorded_room.PREFIX


def test_an_unfinished_recording_is_read_to_its_last_whole_chunk(unfinished: IndexedBag) -> None:
    end_ns = unfinished.end_ns
    assert END_NS - 10**9 < end_ns < END_NS
    read = [Recorded(*vars(it).values()) for it in unfinished.after(BEGIN_NS)]
    assert read == [it for it in ALL if it.time_ns > BEGIN_NS][: len(read)]
    assert found(unfinished, time_ns(30), EYE, History(1, 0)) == before(time_ns(30), EYE)[-1:]
    assert unfinished.counts[BATTERY] == 1


def test_a_damaged_chunk_is_an_error_and_the_others_are_read(tmp_path: Path) -> None:
    bag = IndexedBag(recorded_room.write_damaged(tmp_path / "room"))
    with pytest.raises(RecordingError, match="is broken"):
        list(bag.after(BEGIN_NS))
    assert found(bag, time_ns(5), WORLD, History(1, 0)) == before(time_ns(5), WORLD)[-1:]


def test_an_index_that_points_nowhere_is_not_taken(tmp_path: Path) -> None:
    folder = recorded_room.write(tmp_path / "room")
    (file,) = folder.glob("*.mcap")
    data = file.read_bytes()
    # The first chunk, as its index names it: begin, end, offset.
    times = BEGIN_NS.to_bytes(8, "little")
    at = data.rindex(times)
    file.write_bytes(data[: at + 16] + (1 << 62).to_bytes(8, "little") + data[at + 24 :])
    read = [Recorded(*vars(it).values()) for it in IndexedBag(folder).after(BEGIN_NS)]
    assert read == [it for it in ALL if it.time_ns > BEGIN_NS]
