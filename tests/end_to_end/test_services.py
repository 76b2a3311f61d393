"""The headset's app calls services of ROS and offers its own, and each call has one outcome."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import random
import subprocess
import sys
import threading
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from subprocess import Popen
from typing import Any

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import SetBool

from configurations import only
from ml2_receiver.ros.context import tool_node
from processes import (
    PATHS,
    headset_command,
    isolated_environment,
    line_with,
    lines,
    listening_address,
    process,
    receive_command,
)
from proxy import Proxy
from ros_client import await_heard
from test_subscriptions import CUTS
from waiting import LIMIT_S, await_true, is_done

CONFIG = only(
    "app: {call: ['/robot/*'], offer: [/magic_leap2/custom/on]}, other_sensors: {enabled: true}"
)
SET_BOOL = "std_srvs/srv/SetBool"
NAMES = ("fast", "slow", "silent", "dying", "absent")
DEEP = QoSProfile(depth=100)
# So many calls of each side are under way; 200 cuts make more than 10,000 calls of each.
AT_ONCE = 13
# Says when it was asked for `true`, and then answers nothing.
DYING = """
import threading, rclpy
from std_srvs.srv import SetBool

def ask(request, answer):
    if request.data:
        print("asked", flush=True)
        threading.Event().wait()
    return answer

rclpy.init()
node = rclpy.create_node("dying")
node.create_service(SetBool, "/robot/dying", ask)
print("ready", flush=True)
rclpy.spin(node)
"""


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in isolated_environment().items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def address(ros: None, tmp_path: Path) -> Iterator[str]:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    command = receive_command(config, "127.0.0.1:0", "--insecure-control")
    with process(command, dict(os.environ), tmp_path / "receiver.log") as receiver:
        yield listening_address(receiver)


class Headset:
    """A headset that calls services, and offers one; `said` has the lines that it has printed."""

    def __init__(self, running: Popen[str]) -> None:
        self.said: list[str] = []
        self.outcomes: dict[int, list[str]] = defaultdict(list)
        self._running, self._asked = running, 0
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        for line in lines(self._running):
            self.said.append(line.rstrip("\n"))
            if line.startswith("/robot/"):
                _, number, outcome = self.said[-1].split(" ", 2)
                self.outcomes[int(number)].append(outcome)

    def join(self) -> None:
        """Waits for the end of the headset, whose output has been read then."""
        self._running.terminate()
        self._reader.join()

    def ask(self, name: str, timeout_s: float = LIMIT_S, *, value: bool = True) -> int:
        """Calls a service; returns the number of the call."""
        assert self._running.stdin is not None
        request = json.dumps({"data": value})
        self._running.stdin.write(f"/robot/{name} {timeout_s} {request}\n")
        self._running.stdin.flush()
        self._asked += 1
        return self._asked - 1

    def await_outcomes(self, calls: list[int], count: int | None = None) -> None:
        """Waits until so many of the calls have ended, or all."""
        enough = len(calls) if count is None else count
        await_true(lambda: sum(it in self.outcomes for it in calls) >= enough)

    def outcome(self, number: int) -> str:
        """Waits for the outcome of a call, and returns it."""
        await_true(lambda: number in self.outcomes)
        return self.outcomes[number][0]

    def await_offers(self, count: int) -> None:
        """Waits until the receiver has offered the app's service so often."""
        self.await_line("custom/on is offered as /magic_leap2/custom/on", count)

    def await_line(self, line: str, count: int = 1) -> None:
        """Waits until a line has been read so often; an answer may be here before it."""
        await_true(lambda: self.said.count(line) >= count)


@contextlib.contextmanager
def calling(address: str, folder: Path) -> Iterator[Headset]:
    words = [word for name in NAMES for word in ("--call", f"/robot/{name}", SET_BOOL)]
    command = headset_command(address, *words, "--offer", "custom/on", SET_BOOL)
    log = folder / "headset.log"
    with process(command, dict(os.environ), log, stdin=subprocess.PIPE) as running:
        headset = Headset(running)
        try:
            yield headset
        finally:
            headset.join()


@contextlib.contextmanager
def spinning(name: str) -> Iterator[Node]:
    with tool_node(name) as node:
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        thread = threading.Thread(target=executor.spin)
        thread.start()
        try:
            yield node
        finally:
            executor.shutdown()
            thread.join()


def said(message: str) -> str:
    return f'{{"success":true,"message":"{message}"}}'


def answered(headset: Headset, name: str, *, value: bool = True) -> str:
    """Calls until headset, receiver and service know each other, and returns the answer."""
    while True:
        outcome = headset.outcome(headset.ask(name, 1, value=value))
        if not outcome.startswith(("LINK_DOWN", "UNAVAILABLE", "TIMEOUT")):
            return outcome


def test_services_that_are_slow_silent_or_absent_each_have_their_outcome(
    address: str, tmp_path: Path
) -> None:
    may_answer = threading.Event()

    def fast(request: Any, answer: Any) -> Any:
        answer.success, answer.message = request.data, "fast"
        return answer

    def slow(request: Any, answer: Any) -> Any:
        may_answer.wait(LIMIT_S)
        answer.success, answer.message = True, "slow"
        return answer

    with spinning("fast") as node, spinning("slow") as other, tool_node("silent") as silent:
        node.create_service(SetBool, "/robot/fast", fast)
        other.create_service(SetBool, "/robot/slow", slow)
        silent.create_service(SetBool, "/robot/silent", fast)  # whose node is not spun
        with calling(address, tmp_path) as headset:
            assert answered(headset, "fast") == said("fast")
            refusing = headset.ask("fast", value=False)
            assert headset.outcome(refusing) == '{"success":false,"message":"fast"}'
            may_answer.set()
            answered(headset, "slow")
            may_answer.clear()
            is_slow = headset.ask("slow")
            assert headset.outcome(headset.ask("fast")) == said("fast")
            may_answer.set()
            assert headset.outcome(is_slow) == said("slow")
            # It is unavailable until the receiver has found it
            await_true(
                lambda: headset.outcome(headset.ask("silent", 1)).startswith(
                    "TIMEOUT: /robot/silent: "
                )
            )
            absent = headset.outcome(headset.ask("absent"))
            assert absent.startswith("UNAVAILABLE: /robot/absent: ")


def test_a_service_that_is_killed_while_it_is_asked_is_unavailable(
    address: str, tmp_path: Path
) -> None:
    command, environment = [sys.executable, "-c", DYING], os.environ | PATHS
    with (
        process(command, environment, tmp_path / "dying.log") as dying,
        calling(address, tmp_path) as headset,
    ):
        line_with(dying, "ready")
        answered(headset, "dying", value=False)
        number = headset.ask("dying")
        line_with(dying, "asked")
        dying.kill()
        assert headset.outcome(number).startswith("UNAVAILABLE: /robot/dying: ")


def test_nodes_of_ros_call_a_service_of_the_app(address: str, tmp_path: Path) -> None:
    with spinning("caller") as node, calling(address, tmp_path) as headset:
        client = node.create_client(SetBool, "/magic_leap2/custom/on")
        assert client.wait_for_service(LIMIT_S)
        await_heard(node, is_done)
        for number, value in enumerate((True, False, True)):
            future = client.call_async(SetBool.Request(data=value))
            await_true(future.done)
            answer = SetBool.Response(success=True, message=f"request {number}")
            assert future.result() == answer
            headset.await_line(f'custom/on request {number} {{"data":{str(value).lower()}}}')


def test_over_link_cuts_each_call_of_both_sides_has_one_answer(
    address: str, tmp_path: Path
) -> None:
    chance, served = random.Random(1), itertools.count()
    futures: list[Any] = []

    def count(request: Any, answer: Any) -> Any:
        if request.data:
            answer.success, answer.message = True, f"request {next(served)}"
        return answer

    with (
        spinning("robot") as node,
        Proxy(address) as proxy,
        calling(proxy.address, tmp_path) as headset,
    ):
        node.create_service(SetBool, "/robot/fast", count, qos_profile=DEEP)
        client = node.create_client(SetBool, "/magic_leap2/custom/on", qos_profile=DEEP)
        answered(headset, "fast", value=False)
        await_heard(node, is_done)
        headset.outcomes.clear()
        for cut in range(CUTS):
            headset.await_offers(cut + 1)
            assert client.wait_for_service(LIMIT_S)
            for is_last in (False, False, False, True):
                calls = [headset.ask("fast") for _ in range(AT_ONCE)]
                futures.extend(client.call_async(SetBool.Request()) for _ in calls)
                if is_last:
                    headset.await_outcomes(calls, chance.randrange(AT_ONCE + 1))
                    proxy.cut()
                headset.await_outcomes(calls)
                await_true(lambda: all(it.done() for it in futures[-AT_ONCE:]))
    outcomes = headset.outcomes.values()
    assert len(outcomes) == len(futures) == 4 * AT_ONCE * CUTS
    assert {len(it) for it in outcomes} == {1}
    by_app = [json.loads(it)["message"] for (it,) in outcomes if it.startswith("{")]
    by_ros = [it.result().message for it in futures if it.result().success]
    requests = sum(it.startswith("custom/on request") for it in headset.said)
    for answers, asked in ((by_app, next(served)), (by_ros, requests)):
        assert len(set(answers)) == len(answers)
        assert 2 * AT_ONCE * CUTS <= len(answers) <= asked <= 4 * AT_ONCE * CUTS
    failed = [it for (it,) in outcomes if not it.startswith("{")]
    assert {it.split(":")[0] for it in failed} <= {"LINK_DOWN", "UNAVAILABLE"}
