"""Tests the report of `make links` on a changed link, with arrivals written down by hand."""

from __future__ import annotations

import numpy as np

from link_changes import Change, followed


def test_followed_reads_backlog_settling_and_use_from_arrivals() -> None:
    # 100 samples a second; those of 9.5 to 10 s come at 10.2 s, those of 12.0 to 12.4 s 80 ms late.
    stamps_s = np.arange(0, 20, 0.01)
    latency_s = np.full_like(stamps_s, 0.002)
    waits = (stamps_s >= 9.5) & (stamps_s < 10)
    latency_s[waits] = 10.2 - stamps_s[waits]
    latency_s[(stamps_s >= 12) & (stamps_s < 12.395)] = 0.080
    imu = np.column_stack((stamps_s + latency_s, latency_s * 1e3))
    # 10 messages a second of 1 MB, so 80 Mbit/s; none from 10 to 11.5 s.
    times_s = np.arange(0, 20, 0.1)
    times_s = times_s[(times_s < 9.95) | (times_s > 11.45)]
    messages = np.column_stack((times_s, np.full_like(times_s, 1e6)))

    stalled, shared = followed([Change(10, 100), Change(15, None)], imu, messages)

    assert stalled["to_mbit"] == 100
    assert np.isclose(stalled["backlog_s"], 0.2)
    assert np.isclose(stalled["settled_s"], 2.39 + 0.08)
    assert 1.4 <= stalled["filled_s"] <= 1.61
    assert shared == {"to_mbit": None, "backlog_s": 0.0, "settled_s": 0.0, "filled_s": None}


def test_a_link_that_is_never_filled_again_has_no_time_of_it() -> None:
    imu = np.array([[1.0, 2.0], [5.0, 2.0]])
    messages = np.array([[1.0, 1e6], [9.0, 1e6]])
    (row,) = followed([Change(2, 100)], imu, messages)
    assert row["filled_s"] is None
