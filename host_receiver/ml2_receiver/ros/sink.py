"""The output to ROS."""

import os
import socket
import threading
import time
from collections.abc import Callable, Mapping
from typing import Self

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String

from ..configuration.calibration import Calibration
from ..configuration.config_file import ConfigFile
from ..configuration.settings import Settings
from ..session.report import Report
from ..session.sink import Applied, Publish
from ..table.reader import load_table
from ..table.stream_table import Topic
from ..topics.config_topic import config_text
from ..topics.control import ReceiverControl
from ..topics.diagnostics import Diagnostics, security_row
from ..topics.fan_out import FanOut
from .calibration_services import add_calibration_services
from .namesakes import Namesakes
from .node import RosNode
from .publishers import Publishers, create_publisher
from .qos_overrides import OVERRIDABLE
from .raw_publish import takes_bytearray
from .real_time import real_time, say_real_time, steady_timer
from .recording_services import RecordingServices
from .services import add_services
from .status_array import DIAGNOSTICS, status_array

_DIAGNOSTICS_PERIOD_S = 1.0


class RosSink:
    """A Sink that publishes as `node`, and answers that node's services and parameters.

    It does so while it is entered. It publishes the table's topics under the prefix, `config` and
    `log` beside them, and the report on /diagnostics once per second. Thread-safe.

    Args:
        file: what ~/reload reads and ~/save_config writes.
        calibrate: takes the user's calibrations by stream, whenever settings or they change.
        sinks: what can be recorded; it adds itself to them.
    """

    def __init__(
        self,
        node: RosNode,
        control: ReceiverControl,
        file: ConfigFile,
        calibrate: Callable[[Mapping[str, Calibration]], None],
        sinks: FanOut,
    ) -> None:
        self._ros, self._node = node, node.parameters
        self._control, self._calibrate = control, calibrate
        table = load_table()
        self._prefix = prefix = node.config.prefix
        self._own = {
            topic.name: create_publisher(
                self._node, f"{prefix}/{topic.name}", topic.type, table.qos[topic.qos]
            )
            for topic in table.receiver_topics
        }
        self._diagnostics = Diagnostics(prefix)
        self._namesakes = Namesakes(self._node, node.config.name, f"{prefix}/config")
        self._reporting = threading.Lock()
        self._statuses = self._node.create_publisher(
            DiagnosticArray, DIAGNOSTICS, 10, qos_overriding_options=OVERRIDABLE
        )
        self._publishers = Publishers(
            self._node,
            table,
            prefix,
            takes_bytearray=takes_bytearray(self._statuses, DiagnosticArray()),
            demand=lambda streams: control.demand("ros", streams),
        )
        add_services(self._node, control, file)
        add_calibration_services(self._node, prefix, file)
        self._recording = RecordingServices(self._node, control, prefix, sinks)
        self._node.on_change(self._settings_changed)
        steady_timer(self._node, _DIAGNOSTICS_PERIOD_S, self._each_second)
        say_real_time(self._node)
        self._sinks = sinks

    def __enter__(self) -> Self:
        """Adds itself to the sinks, and spins the node."""
        self._sinks.add(self)
        self._ros.spin()
        return self

    def __exit__(self, *_: object) -> None:
        """Ends the recording there may be, also while a callback hangs."""
        self._ros.end_spinning()
        self._recording.close()

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

    def _settings_changed(self, settings: Settings) -> None:
        for problem in settings.pending:
            self.event(f"{problem.located_in('')}: waiting")
        config = settings.config
        self._calibrate(config.calibrations)
        self._control.request(config.requests, config.link, is_lazy=config.is_lazy)

    def _each_second(self) -> None:
        self._report(self._control.report())
        if (news := self._namesakes.news()) is not None:
            self._node.get_logger().warning(news)
            self._own["log"].publish(String(data=f"WARNING: {news}"))

    def _report(self, report: Report | None) -> None:
        with self._reporting:
            rows = self._diagnostics.rows(report, time.monotonic()) + self._node.failures.rows()
        rows += self._recording.rows(report)
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
        self._statuses.publish(status_array(self._ros.config.name, rows, more, real_time()))
