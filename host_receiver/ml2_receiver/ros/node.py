"""The node, and the thread that spins it."""

import threading
from collections.abc import Sequence
from typing import Self

import rclpy  # whose absence is named
import rclpy.utilities
from rclpy.executors import SingleThreadedExecutor

from ..configuration.config import Config
from .context import end_node, start_node
from .parameters import ParameterNode
from .spinning import spin_until, wake

# The longest that the end of the node waits for a callback.
_CALLBACK_S = 2.0


class RosNode:
    """The node `ml2_receiver`, whose parameters are the configuration, until left.

    Leaving frees the shared memory of the middleware.

    Args:
        config: what parameters that are not among `arguments` say.
        arguments: for ROS, as `["--ros-args", ...]`.

    Attributes:
        parameters: the node of rclpy; used by the spinning thread, once there is one.

    Raises:
        RosError: ROS does not take them.
        ConfigError: parameters among them are wrong.
    """

    def __init__(self, config: Config, arguments: Sequence[str]) -> None:
        self.parameters = start_node(
            lambda context: ParameterNode("ml2_receiver", context, config), arguments
        )
        self._context = self.parameters.context
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.parameters)
        self._is_ending = threading.Event()
        self._spinner = threading.Thread(target=self._spin, name="spinner")

    @property
    def config(self) -> Config:
        """The configuration in force."""
        return self.parameters.config

    @property
    def middleware(self) -> str:
        """The identifier of ROS's middleware, such as "rmw_fastrtps_cpp"."""
        return rclpy.utilities.get_rmw_implementation_identifier()

    @property
    def name(self) -> str:
        """The name of the node, without its namespace, after the remappings of ROS's arguments."""
        return str(self.parameters.get_name())

    def remapped(self, name: str, *, is_service: bool = False) -> str:
        """Returns the node's full name of a topic, or of a service. Any thread may call it."""
        if is_service:
            return str(self.parameters.resolve_service_name(name))
        return self.parameters.resolve_topic_name(name)

    def spin(self) -> None:
        """Runs the node's callbacks in a thread, until end_spinning()."""
        self._spinner.start()

    def end_spinning(self) -> None:
        """Ends the thread, but does not wait longer than 2 s for a callback that hangs."""
        self._is_ending.set()
        wake(self._executor)
        if self._spinner.is_alive():
            self._spinner.join(_CALLBACK_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._spinner.is_alive():
            return  # a callback that hangs uses them
        self._executor.shutdown()
        end_node(self.parameters)

    def _spin(self) -> None:
        while self._context.ok() and not self._is_ending.is_set():
            try:
                spin_until(self._executor, self._is_ending.is_set)
            except Exception as error:
                self.parameters.failures.add(error)
