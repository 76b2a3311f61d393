from ml2_receiver.table.reader import load_table
from ml2_tools.doctor.devices import DeviceStream, read_device

SESSION = {
    "state": "connected",
    "headset": "Magic Leap 2",
    "device_id": "id",
    "software": "ml2-sensors 1",
    "capabilities": "world_left world_right depth battery",
    "permission.android.permission.CAMERA": "true",
    "permission.com.magicleap.permission.DEPTH_CAMERA": "false",
    "stream.world_left": "applied",
    "stream.battery": "adjusted: slower",
}
ADAPTATION = {"battery.rate_hz": "10", "message": "lowered for the link: battery: 10 Hz"}


def streams(**changes: str) -> dict[str, DeviceStream]:
    device = read_device({"session": SESSION | changes, "adaptation": ADAPTATION}, load_table())
    assert device is not None
    return {it.stream: it for it in device.streams}


def test_every_stream_of_the_table_is_listed() -> None:
    assert streams().keys() == load_table().streams.keys()


def test_each_stream_has_its_state_and_reason() -> None:
    found = streams()
    assert found["world_left"] == DeviceStream("world_left", "runs", "")
    assert found["battery"] == DeviceStream("battery", "runs", "slower", "10 Hz")
    assert found["world_right"].state == "off"
    assert found["gaze"] == DeviceStream("gaze", "unavailable", "this headset has no such sensor")
    assert found["depth"].reason == (
        "permission com.magicleap.permission.DEPTH_CAMERA is not granted"
    )


def test_a_stream_that_stopped_is_not_shown_as_running() -> None:
    camera = "android.permission.CAMERA"
    found = streams(
        **{
            "state.world_left": f"waiting: {camera} was taken away",
            "missing.world_left": camera,
            "state.battery": "failed: gone",
            "stream.world_right": "applied",
            "state.world_right": "running",
            "stream.depth": "refused: not now",
            "state.depth": "available: not now",
        }
    )
    fix = f"{camera} is missing: run `ml2-receiver headset grant world_left`"
    expected = DeviceStream("world_left", "waiting", f"{camera} was taken away; {fix}")
    assert found["world_left"] == expected
    assert found["battery"] == DeviceStream("battery", "failed", "gone", "10 Hz")
    assert found["world_right"] == DeviceStream("world_right", "runs", "")
    assert found["depth"] == DeviceStream("depth", "waiting", "not now")


def test_what_the_headset_answers_is_surer_than_what_can_be_guessed() -> None:
    found = streams(**{"stream.depth": "refused: hot: 60 degrees"})
    assert found["depth"] == DeviceStream("depth", "unavailable", "hot: 60 degrees")


def test_before_the_first_headset_there_is_none() -> None:
    assert read_device({"session": {"state": "waiting"}}, load_table()) is None
    assert read_device({}, load_table()) is None
