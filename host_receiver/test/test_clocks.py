"""/diagnostics goes on each second when the PC's clock steps back, or ROS's clock stands still."""

import ctypes.util
import shutil
import subprocess
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from configurations import only
from ml2_tools.commands.recording_wait import Standing, wait
from ros_messages import TYPES
from ros_processes import Child, Receiver, Subscriber

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("battery: {enabled: true}")
TYPE = "diagnostic_msgs/msg/DiagnosticArray"
SIM_TIME = ("--ros-args", "-p", "use_sim_time:=true")
SAID = "use_sim_time is set: sensor stamps and /diagnostics stay in real time"
ONE_HOUR_S = 3600
# A library that steps the real-time clock of its process back by an hour, as soon as the file
# exists that the environment variable STEPPED names.
STEPPING = f"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t clock, struct timespec *now)
{{
    static int (*real)(clockid_t, struct timespec *);
    if (!real)
        real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, now);
    if (clock == CLOCK_REALTIME && access(getenv("STEPPED"), F_OK) == 0)
        now->tv_sec -= {ONE_HOUR_S};
    return result;
}}
"""


# Publishes a clock that runs, steps back and stops, as soon as somebody uses it.
CLOCK = """
import time
import rclpy
from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock
rclpy.init()
node = rclpy.create_node("clock")
publisher = node.create_publisher(Clock, "/clock", 10)
while not publisher.get_subscription_count():
    time.sleep(0.01)
for sec in (1000, 1001, 1002, 1, 2, 2):
    publisher.publish(Clock(clock=Time(sec=sec)))
print("stopped", flush=True)
rclpy.spin(node)
"""


def stamp_s(payload: bytes) -> int:
    return int(TYPES.deserialize_cdr(payload, TYPE).header.stamp.sec)  # type: ignore[attr-defined]


@pytest.fixture
def step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that steps the clock of later children back when it is made."""
    compiler = shutil.which("cc")
    if compiler is None or ctypes.util.find_library("c") is None:
        pytest.skip("there is no C compiler")
    source, library, step = (tmp_path / name for name in ("step.c", "step.so", "stepped"))
    source.write_text(STEPPING)
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(library))
    monkeypatch.setenv("STEPPED", str(step))
    return step


@pytest.mark.parametrize("program", ["receiver", "products"])
def test_diagnostics_go_on_when_the_clock_steps_back(
    program: str, config: Path, step: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    child = Receiver(config) if program == "receiver" else Child("-m", "ml2_receiver", "products")
    monkeypatch.delenv("LD_PRELOAD")
    with child, Subscriber("/diagnostics", TYPE) as subscriber:
        before_s = stamp_s(subscriber.message())
        step.touch()
        while stamp_s(subscriber.message()) > before_s - ONE_HOUR_S / 2:
            pass
        subscriber.message()


@pytest.mark.parametrize("program", ["receiver", "products"])
@pytest.mark.parametrize("has_clock", [False, True])
def test_diagnostics_go_on_in_real_time_with_any_clock_and_without_one(
    program: str, config: Path, has_clock: bool
) -> None:
    began_s = int(time.time())
    child = (
        Receiver(config, *SIM_TIME)
        if program == "receiver"
        else Child("-m", "ml2_receiver", "products", *SIM_TIME)
    )
    with child, ExitStack() as stack:
        if has_clock:
            assert stack.enter_context(Child("-c", CLOCK)).line() == "stopped"
        subscriber = stack.enter_context(Subscriber("/diagnostics", TYPE))
        for _ in range(2):
            assert stamp_s(subscriber.message()) >= began_s
        child.await_error(SAID)
        assert sum(SAID in line for line in child.errors) == 1


def test_no_other_timer_follows_a_clock_that_can_stop() -> None:
    root = Path(__file__).resolve().parents[1]
    sources = [path for top in ("ml2_receiver", "ml2_tools") for path in (root / top).rglob("*.py")]
    timers = [path.name for path in sources if "create_timer(" in path.read_text()]
    assert timers == ["real_time.py"]


def test_a_recording_lasts_as_asked_when_the_clock_has_stepped() -> None:
    stopping = threading.Event()
    said = [Standing(ONE_HOUR_S, 1, 2, ""), Standing(0, 0, 0, "")]

    def standing() -> Standing:
        """Has no message, then two that seem an hour apart, and then is stopped by the user."""
        if not said:
            stopping.set()
            return Standing(ONE_HOUR_S, 1, 3, "")
        return said.pop()

    wait(stopping, 1000, standing)
    assert stopping.is_set()
