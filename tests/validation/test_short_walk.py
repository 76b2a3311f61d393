"""A short walk through headset, receiver and ROS 2, evaluated from its images."""

from pathlib import Path

import pytest

from processes import Received
from simulated_walk import FellBehindError, check_nothing_is_lost, stream
from simulation import EXACT
from validate import evaluate
from walks import Walk

WALK = Walk("short", "world_center", 2.0, 0.8, 40)


def test_estimated_poses_agree_with_the_headsets_poses_and_the_true_ones(tmp_path: Path) -> None:
    walked = stream(WALK, tmp_path / "walk", EXACT, late=6)
    figures = evaluate(tmp_path / "walk", WALK.camera, walked.truth)
    assert figures["images_received"] == walked.images_sent >= 55
    assert figures["matched_pairs"] >= 0.99 * walked.images_sent
    assert figures["path_m"] == pytest.approx(WALK.path_m, abs=0.01)
    for against in (figures, figures["truth"]):
        assert against["rmse_m"] < 0.01
        assert abs(against["time_offset_s"]) < 1e-3
        assert against["max_dt_s"] < 1e-3
    assert figures["headset_against_truth"]["max_m"] < 1e-3


@pytest.mark.parametrize(
    ("count", "dropped", "expected"),
    [
        (10, {}, None),
        (9, {"dropped.source_late": "1", "dropped.no_buffer": "0"}, None),
        (9, {"dropped.no_buffer": "1"}, FellBehindError),
        (9, {}, RuntimeError),
    ],
    ids=["all", "late", "busy", "lost"],
)
def test_a_walk_is_repeated_where_a_busy_machine_dropped_messages(
    count: int, dropped: dict[str, str], expected: type[Exception] | None
) -> None:
    row = {"count": count, "diagnostics": {"produced": "10", **dropped}}
    received = Received({"topics": {"/tf": row}}, {}, {}, [], {}, {}, [])
    if expected is None:
        check_nothing_is_lost(received)
    else:
        with pytest.raises(expected):
            check_nothing_is_lost(received)
