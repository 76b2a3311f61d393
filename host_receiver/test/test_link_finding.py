"""The doctor judges the link to a headset."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from configurations import only_config
from ml2_tools.doctor.link_finding import link_finding

SESSION = {"state": "connected"}
IMAGE_ROW = {
    "rate_hz": "29.04",
    "expected_hz": "30",
    "mbit_per_s": "242.0",
    "latency_p99_ms": "12.5",
}
IMU_ROW = {"rate_hz": "200.0", "mbit_per_s": "0.5"}
PAUSED_ROW = {"rate_hz": "0.00", "expected_hz": "30", "mbit_per_s": "0.00"}
ROWS = {"session": SESSION, "/a": IMAGE_ROW, "/b": IMU_ROW, "/c": PAUSED_ROW}


def tried(free: float, streams: float) -> dict[str, str]:
    rates = {"free_mbit_per_s": f"{free}", "streams_mbit_per_s": f"{streams}"}
    return {"state": "measured", "filler_bytes": "67108864", "duration_s": "1.3", **rates}


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ("no receiver runs here", "not measured: no receiver runs here"),
        ({"session": {"state": "waiting"}}, "not measured: the session is waiting"),
    ],
)
def test_without_a_headset_no_link_is_measured(
    rows: dict[str, dict[str, str]] | str, found: str
) -> None:
    finding = link_finding(rows, "")
    assert (finding.level, finding.found, finding.numbers) == ("hint", found, {})


def test_a_link_that_carries_more_than_its_streams_need_is_well() -> None:
    finding = link_finding(ROWS, tried(412.0, 240.0))
    assert (finding.level, finding.fix) == ("ok", "")
    assert finding.found == (
        "242.5 Mbit/s arrive, p99 of the slowest topic 12.5 ms; in a test 412.0 Mbit/s were free"
        " besides 240.0 of the streams, which need 250.5"
    )
    assert finding.numbers == pytest.approx(
        {
            "arriving_mbit_per_s": 242.5,
            "needed_mbit_per_s": 250.5,
            "slowest_p99_ms": 12.5,
            "dropped": 0,
            "free_mbit_per_s": 412.0,
            "streams_mbit_per_s": 240.0,
            "filler_bytes": 67108864,
            "duration_s": 1.3,
        }
    )


def test_a_link_that_carries_too_little_has_a_fix() -> None:
    finding = link_finding(ROWS, tried(100.0, 150.0))
    assert finding.level == "hint"
    for remedy in ("5 or 6 GHz", "cable", "update_rate", "compressed"):
        assert remedy in finding.fix


@pytest.mark.parametrize(
    ("test", "fix"),
    [
        (tried(100.0, 150.0), "cable"),
        ("the headset does not answer", "cable"),
        (tried(900.0, 250.0), "look whether this machine is busy"),
    ],
)
def test_full_queues_are_a_hint_however_much_is_free(test: dict[str, str] | str, fix: str) -> None:
    rows = ROWS | {"/a": IMAGE_ROW | {"dropped.queue_full": "7"}}
    finding = link_finding(rows, test)
    assert (finding.level, fix in finding.fix) == ("hint", True)
    assert "; 7 messages were dropped as the link or this machine was too slow" in finding.found


@pytest.mark.parametrize(
    ("test", "why"),
    [
        ("the headset does not answer", "the headset does not answer"),
        ({"state": "unanswered", "message": "link test: unanswered"}, "link test: unanswered"),
    ],
)
def test_a_link_that_was_not_tried_is_no_more_than_what_arrives(
    test: dict[str, str] | str, why: str
) -> None:
    finding = link_finding(ROWS, test)
    assert finding.level == "hint"
    assert finding.found.endswith(f"; what more it carries is not known: {why}")
    assert set(finding.numbers) == {
        "arriving_mbit_per_s",
        "needed_mbit_per_s",
        "slowest_p99_ms",
        "dropped",
    }


def row(stream: str, rate_hz: float, mbit_per_s: float, expected_hz: float = 30) -> dict[str, str]:
    numbers = {"rate_hz": rate_hz, "mbit_per_s": mbit_per_s, "expected_hz": expected_hz}
    return {"stream": stream} | {key: str(value) for key, value in numbers.items()}


RAW = only_config("world_left: {enabled: true}, world_right: {enabled: true}")
RAW_ROWS = {
    "session": SESSION,
    "/left": row("world_left", 30, 248),
    "/left/info": row("world_left", 30, 0.1),
    "/right": row("world_right", 30, 248),
    "/imu": IMU_ROW | {"stream": "imu_left"},
}


@pytest.mark.parametrize(
    ("free", "fix"),
    [
        (
            300.0,
            "run `ml2-receiver set world_left.format=jpeg world_right.format=jpeg`: images then"
            " need about 68 Mbit/s",
        ),
        (
            1.0,
            "run `ml2-receiver set world_left.format=jpeg world_left.quality=60"
            " world_right.format=jpeg world_right.quality=60`: images then need about 44 Mbit/s",
        ),
    ],
)
def test_the_change_that_fits_the_link_is_named(free: float, fix: str) -> None:
    finding = link_finding(RAW_ROWS, tried(free, 60.0), RAW)
    assert finding.level == "hint"
    assert finding.fix.startswith(fix)
    assert finding.fix.endswith("; or use Wi-Fi of 5 or 6 GHz near its access point, or a cable")


def test_the_change_is_for_the_receiver_that_was_asked() -> None:
    finding = link_finding(RAW_ROWS, tried(300.0, 60.0), replace(RAW, name="robot1"))
    both = "world_left.format=jpeg world_right.format=jpeg"
    assert finding.fix.startswith(f"run `ml2-receiver set {both} --name robot1`: ")


def test_where_no_change_fits_images_give_way() -> None:
    """test_link_fit.py has what is said for each general.link."""
    jpeg = only_config("general: {link: fixed}, world_left: {enabled: true, format: jpeg}")
    rows = {"session": SESSION, "/left": row("world_left", 30, 34)}
    finding = link_finding(rows, tried(5.0, 10.0), jpeg)
    fix = "run `ml2-receiver set general.link=auto`: the headset then lowers quality and"
    assert finding.fix.startswith(fix)
    assert finding.fix.endswith("; or use Wi-Fi of 5 or 6 GHz near its access point, or a cable")


LOWERED = {"message": "lowered for the link: world_left 15 Hz"}


@pytest.mark.parametrize(
    ("rows", "needed"),
    [
        ({}, 496.6),
        ({"/left": row("world_left", 15, 124)}, 496.6),
        ({"/left": row("world_left", 0, 0)}, 248.0 + 247.7 + 0.5),
        (
            {
                "/left": row("world_left", 15, 124, 15),
                "adaptation": LOWERED | {"world_left.rate_hz": "15"},
            },
            248.0 + 247.7 + 0.5,
        ),
        (
            {
                "/left": row("world_left", 0, 0),
                "session": SESSION | {"stream.world_left": "refused: no permission"},
            },
            248.0 + 0.1 + 0.5,
        ),
    ],
    ids=["whole", "lossy", "silent", "lowered", "refused"],
)
def test_what_is_needed_is_what_the_configuration_asks_for(
    rows: dict[str, Mapping[str, str]], needed: float
) -> None:
    numbers = link_finding({**RAW_ROWS, **rows}, tried(900.0, 400.0), RAW).numbers
    assert numbers["needed_mbit_per_s"] == pytest.approx(needed, abs=0.1)


def test_what_is_lowered_is_told() -> None:
    rows = RAW_ROWS | {"adaptation": LOWERED | {"world_left.rate_hz": "15"}}
    finding = link_finding(rows, tried(100.0, 300.0), RAW)
    assert finding.found.endswith("; lowered for the link: world_left 15 Hz")
    well = RAW_ROWS | {"adaptation": {"message": "nothing is lowered"}}
    assert "is lowered" not in link_finding(well, tried(900.0, 300.0), RAW).found


def test_without_images_a_better_link_is_what_helps() -> None:
    imu = {"session": SESSION, "/imu": IMU_ROW | {"stream": "imu_left", "mbit_per_s": "10"}}
    small = only_config("imu: {united: true}")
    assert link_finding(imu, tried(1.0, 5.0), small).fix.startswith("use Wi-Fi of 5 or 6 GHz")


def test_a_link_that_just_carries_what_is_needed_needs_no_change() -> None:
    rows = RAW_ROWS | {"/left": row("world_left", 30, 248.006)}
    assert link_finding(rows, tried(0.0, 496.606), RAW).level == "ok"


def test_images_get_what_the_other_streams_leave() -> None:
    imu = {"stream": "imu_left", "rate_hz": "200.0", "mbit_per_s": "60"}
    finding = link_finding(RAW_ROWS | {"/imu": imu}, tried(60.0, 60.0), RAW)
    assert "images then need about 44 Mbit/s" in finding.fix


@pytest.mark.parametrize("text", ["", "nan", "inf", "-1e308", "1e308", "x", "9" * 5000])
def test_what_other_nodes_write_is_no_number(text: str) -> None:
    hostile = dict.fromkeys((*IMAGE_ROW, "dropped.queue_full"), text) | {"stream": "world_left"}
    test = dict.fromkeys(tried(1.0, 1.0), text) | {"state": "measured"}
    finding = link_finding(
        {**ROWS, "/d": hostile}, test, only_config("world_left: {enabled: true}")
    )
    assert len(finding.found) < 500
    assert all(abs(it) < 1e16 for it in finding.numbers.values())
