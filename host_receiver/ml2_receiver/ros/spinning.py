"""Spins an executor until something has happened.

rclpy's spin_until_future_complete() adds a callback to the future with every message. All of them
stay in memory until the future is done, and in the executor afterwards.
"""

import time
from collections.abc import Callable
from math import inf

from rclpy.executors import Executor


def spin_until(executor: Executor, is_done: Callable[[], bool], timeout_s: float = inf) -> bool:
    """Runs callbacks until `is_done` returns True after one of them, or until the timeout.

    Returns what `is_done` returned last. wake() has it asked when there are no messages.
    """
    deadline_s = time.monotonic() + timeout_s
    while not (done := is_done()) and (left_s := deadline_s - time.monotonic()) > 0:
        executor.spin_once(left_s if left_s < inf else None)
    return done


def wake(executor: Executor) -> None:
    """Lets spin_until() in another thread ask again. Thread-safe."""
    executor.create_task(lambda: None)
