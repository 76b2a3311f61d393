"""The node, and the thread that spins it."""

import os
import socket
import threading
import time
from collections.abc import Callable, Mapping, Sequence

import rclpy
import rclpy.utilities
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String

from ..configuration.calibration import Calibration
from ..configuration.config import Config
from ..configuration.config_file import ConfigFile
from ..configuration.settings import Settings
from ..errors import ConfigError
from ..session.report import Report
from ..session.sink import Applied, Publish
from ..table.stream_table import StreamTable, Topic
from ..topics.config_topic import config_text
from ..topics.control import Control
from ..topics.diagnostics import Diagnostics, security_row
from ..topics.fan_out import FanOut
from .calibration_services import add_calibration_services
from .context import start_ros
from .namesakes import Namesakes
from .parameters import ParameterNode
from .publishers import Publishers, create_publisher
from .raw_publish import takes_bytearray
from .real_time import real_time, say_real_time, steady_timer
from .recording_services import RecordingServices
from .services import add_services
from .spinning import spin_until, wake
from .status_array import status_array

_DIAGNOSTICS_PERIOD_S = 1.0
# The longest that the end of the node waits for a callback.
_CALLBACK_S = 2.0


class RosNode:
    """The node `ml2_receiver`, a Sink.

    It publishes the table's topics under the prefix, `config` and `log` beside them, and
    /diagnostics; serve() adds services, and lets parameters change what runs. Thread-safe. close()
    frees the shared memory of the middleware.

    Args:
        config: what parameters that are not among `arguments` say.
        arguments: for ROS, as `["--ros-args", ...]`.

    Raises:
        RosError: ROS does not take them.
        ConfigError: parameters among them are wrong.
    """

    def __init__(self, table: StreamTable, config: Config, arguments: Sequence[str]) -> None:
        self._context = start_ros(arguments)
        try:
            self._node = ParameterNode("ml2_receiver", self._context, config)
        except ConfigError:
            rclpy.shutdown(context=self._context)
            raise
        self._prefix = prefix = self.config.prefix
        self._own = {
            topic.name: create_publisher(
                self._node, f"{prefix}/{topic.name}", topic.type, table.qos[topic.qos]
            )
            for topic in table.receiver_topics
        }
        self._diagnostics = Diagnostics(prefix)
        self._namesakes = Namesakes(self._node, self.config.name, f"{prefix}/config")
        self._reporting = threading.Lock()
        self._statuses = self._node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._control: Control | None = None
        self._recording: RecordingServices | None = None
        self._calibrate: Callable[[Mapping[str, Calibration]], None] = lambda _: None
        self._publishers = Publishers(
            self._node,
            table,
            prefix,
            takes_bytearray=takes_bytearray(self._statuses, DiagnosticArray()),
            matched=self._matched,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._is_closing = threading.Event()
        self._spinner = threading.Thread(target=self._spin, name="spinner")

    @property
    def config(self) -> Config:
        """The configuration in force."""
        return self._node.config

    @property
    def middleware(self) -> str:
        """The identifier of ROS's middleware, such as "rmw_fastrtps_cpp"."""
        return rclpy.utilities.get_rmw_implementation_identifier()

    def remapped(self, topic: str) -> str:
        """Returns the name under which the node publishes a topic. Any thread may call it."""
        return self._node.resolve_topic_name(topic)

    def serve(
        self,
        control: Control,
        file: ConfigFile,
        calibrate: Callable[[Mapping[str, Calibration]], None] = lambda _: None,
        sinks: FanOut | None = None,
    ) -> None:
        """Answers services and parameters, and publishes the report once per second.

        Args:
            calibrate: takes the user's calibrations by stream, whenever settings or they change.
            sinks: what can be recorded, this node among them.
        """
        self._control, self._calibrate = control, calibrate
        add_services(self._node, control, file)
        add_calibration_services(self._node, self._prefix, file)
        if sinks is not None:
            self._recording = RecordingServices(self._node, control, self._prefix, sinks)
        self._node.on_change(self._settings_changed)
        steady_timer(self._node, _DIAGNOSTICS_PERIOD_S, lambda: self._each_second(control))
        say_real_time(self._node)
        self._spinner.start()

    def close(self) -> None:
        """Ends the node; nothing may be called after.

        A callback that hangs costs no recording: it is ended without waiting for the callback.
        """
        self._is_closing.set()
        wake(self._executor)
        if self._spinner.is_alive():
            self._spinner.join(_CALLBACK_S)
        if self._recording is not None:
            self._recording.close()
        if self._spinner.is_alive():
            return  # it uses them
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def open(self, topic: Topic) -> Publish:
        return self._publishers.open(topic)

    def configured(self, applied: Applied) -> None:
        self._publishers.keep_only(applied.topics)
        self._own["config"].publish(String(data=config_text(applied, self._prefix)))

    def event(self, text: str) -> None:
        self._node.get_logger().info(text)
        self._own["log"].publish(String(data=text))

    def session_ended(self, report: Report) -> None:
        self._report(report)

    def idle_streams(self) -> set[str]:
        """Returns the streams that nobody needs at present, if `publish.lazy` is set."""
        if self._recording is not None and self._recording.is_on:
            return set()
        return self._publishers.idle_streams() if self.config.values["publish.lazy"] else set()

    def _spin(self) -> None:
        while self._context.ok() and not self._is_closing.is_set():
            try:
                spin_until(self._executor, self._is_closing.is_set)
            except Exception as error:
                self._node.failures.add(error)

    def _matched(self) -> None:
        if self._control is not None and self.config.values["publish.lazy"]:
            self._control.update()

    def _settings_changed(self, settings: Settings) -> None:
        for problem in settings.pending:
            self.event(f"{problem.located_in('')}: waiting")
        self._calibrate(settings.config.calibrations)
        if self._control is not None:
            self._control.request(settings.config.requests, settings.config.link)

    def _each_second(self, control: Control) -> None:
        self._report(control.report())
        if (news := self._namesakes.news()) is not None:
            self._node.get_logger().warning(news)
            self._own["log"].publish(String(data=f"WARNING: {news}"))

    def _report(self, report: Report | None) -> None:
        with self._reporting:
            rows = self._diagnostics.rows(report, time.monotonic()) + self._node.failures.rows()
        if self._recording is not None:
            rows += self._recording.rows(report)
        if self._control is not None:
            rows.append(security_row(self._control.paired()))
        more = {
            topic.full_name(self._prefix): {"subscribers": str(count)}
            for topic, count in self._publishers.subscribers().items()
        }
        more["session"] = {
            "node": self._node.get_fully_qualified_name(),
            "host": socket.gethostname(),
            "pid": str(os.getpid()),
        }
        self._statuses.publish(status_array(self.config.name, rows, more, real_time()))
