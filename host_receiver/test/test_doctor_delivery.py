"""Tests the findings of `doctor` on losses and latencies, by rows of /diagnostics."""

import pytest

from ml2_tools.doctor.delivery import delivery
from ml2_tools.doctor.findings import Finding


def row(received: int, gaps: int = 0, /, **more: str) -> dict[str, str]:
    counts = {"received": str(received), "gaps": str(gaps), "unpublished": "0"}
    return {"stream": "s", **counts, **more}


def dropped(**counts: int) -> dict[str, str]:
    return {f"dropped.{reason}": str(count) for reason, count in counts.items()}


def found(**rows: dict[str, str]) -> dict[str, Finding]:
    return {it.check: it for it in delivery({"session": {"state": "connected"}, **rows})}


def test_losses_are_a_finding_that_names_topics_counts_and_reasons() -> None:
    losses = found(
        imu=row(60_000, 5_242, **dropped(queue_full=5_242)),
        image=row(2_000, 0, **dropped(queue_full=730)),
        battery=row(10),
    )["losses"]
    assert losses.level == "wrong"
    assert losses.found == "lost 5242 of imu (8.0%), 730 of image (26.7%)"
    assert "5972 queue_full" in losses.fix
    assert losses.numbers == {"lost": 5972, "received": 62_010}


@pytest.mark.parametrize(
    ("lost", "level"), [(0, "ok"), (1, "hint"), (100, "hint"), (102, "wrong"), (10_000, "wrong")]
)
def test_any_loss_is_said_and_from_one_percent_on_it_is_wrong(lost: int, level: str) -> None:
    for values in (row(10_000, lost), row(10_000, **dropped(link_down=lost))):
        losses = found(imu=values)["losses"]
        assert losses.level == level
        assert bool(losses.fix) == (level != "ok")


def test_what_arrived_and_was_not_published_is_lost_too() -> None:
    losses = found(imu=row(100, 0, unpublished="100"))["losses"]
    assert losses.level == "wrong"
    assert losses.found == "lost 100 of imu (100.0%)"
    assert "could not publish" in losses.fix


def test_a_topic_that_lost_all_is_wrong() -> None:
    assert found(imu=row(0, **dropped(queue_full=7)))["losses"].found == "lost 7 of imu (100.0%)"


def test_many_topics_make_a_short_finding() -> None:
    losses = found(**{f"t{n}": row(1, n + 1) for n in range(40)})["losses"]
    assert losses.found.startswith("lost 40 of t39 (97.6%), 39 of t38")
    assert losses.found.endswith("and of 35 more topics")


@pytest.mark.parametrize(
    ("p99_ms", "level"), [("20.5", "ok"), ("100", "ok"), ("100.1", "hint"), ("1001", "wrong")]
)
def test_the_topic_with_the_worst_latency_is_named(p99_ms: str, level: str) -> None:
    latency = found(
        a=row(1, latency_p99_ms="3"), b=row(1, latency_p99_ms=p99_ms), c=row(1, latency_p99_ms="9")
    )["latency"]
    assert (latency.level, bool(latency.fix)) == (level, level != "ok")
    assert latency.found.startswith("b is the latest: ")
    assert latency.numbers == {"p99_ms": float(p99_ms)}


def test_before_any_message_there_is_nothing_to_say() -> None:
    assert found(imu=row(0)) == {}
    assert found() == {}


@pytest.mark.parametrize("text", ["nan", "inf", "-1", "9" * 5000, "", "x"])
def test_what_other_nodes_write_is_no_count(text: str) -> None:
    values = row(5) | {"gaps": text, "dropped.x": text, "unpublished": text}
    assert found(imu=values)["losses"].level == "ok"
    latency = found(imu=row(5, latency_p99_ms=text))
    assert len(str(latency)) < 1000
