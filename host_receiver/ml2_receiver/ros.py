"""The ROS 2 node; the only module that imports rclpy."""

import importlib
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle, ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from .config_topic import config_text
from .diagnostics import Diagnostics, Row
from .errors import PublishError, RosError
from .report import Report
from .sink import Applied, Publish
from .table import Qos, StreamTable, Topic

_DIAGNOSTICS_PERIOD_S = 1.0


class RosNode:
    """The node `ml2_receiver`, a Sink.

    It publishes the table's topics under `prefix`, `config` and `log` beside them, and
    /diagnostics; serve() adds what the rest of the receiver answers. Thread-safe. close() frees
    the shared memory of the middleware.

    Args:
        arguments: for ROS, as `["--ros-args", ...]`.

    Raises:
        RosError: ROS does not take them.
    """

    def __init__(self, table: StreamTable, prefix: str, arguments: Sequence[str]) -> None:
        self._table, self._prefix = table, prefix
        self._context = Context()
        try:
            rclpy.init(
                args=["ml2-receiver", *arguments],
                context=self._context,
                signal_handler_options=SignalHandlerOptions.NO,
            )
        except RuntimeError as error:
            raise RosError(f"ROS 2 does not start: {error}") from error
        self._node = rclpy.create_node("ml2_receiver", context=self._context)
        self._publishers: dict[Topic, Publisher] = {}
        self._own = {
            topic.name: self._create(f"{prefix}/{topic.name}", topic.type, table.qos[topic.qos])
            for topic in table.receiver_topics
        }
        self._diagnostics = Diagnostics(prefix)
        self._lock = threading.Lock()
        self._statuses = self._node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._takes_bytearray = takes_bytearray(self._statuses, self._status_array(None))
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._closing = Future(executor=self._executor)
        self._spinner = threading.Thread(
            target=self._executor.spin_until_future_complete, args=[self._closing]
        )

    def serve(self, report: Callable[[], Report | None], start: Callable[[], None]) -> None:
        """Publishes what `report` returns once per second, and calls `start` for ~/start."""

        def respond(_: Any, response: Trigger.Response) -> Trigger.Response:
            start()
            response.success = True
            response.message = "START is sent, or will be when a headset is configured"
            return response

        self._node.create_service(Trigger, "~/start", respond)
        self._node.create_timer(
            _DIAGNOSTICS_PERIOD_S, lambda: self._statuses.publish(self._status_array(report()))
        )
        self._spinner.start()

    def close(self) -> None:
        """Ends the node; nothing may be called after."""
        self._closing.set_result(None)
        if self._spinner.is_alive():
            self._spinner.join()
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def open(self, topic: Topic) -> Publish:
        name = topic.full_name(self._prefix)
        with self._lock:
            if topic not in self._publishers:
                try:
                    publisher = self._create(name, topic.type, self._table.qos[topic.qos])
                except (ParameterException, RuntimeError) as error:  # a wrong QoS override
                    self.event(f"{name} is not published: {error}")
                    return _refuse
                self._publishers[topic] = publisher
            return raw_publish(self._publishers[topic], self._takes_bytearray)

    def configured(self, applied: Applied) -> None:
        with self._lock:
            for topic in self._publishers.keys() - set(applied.topics):
                self._node.destroy_publisher(self._publishers.pop(topic))
        self._own["config"].publish(String(data=config_text(applied, self._prefix)))

    def event(self, text: str) -> None:
        self._node.get_logger().info(text)
        self._own["log"].publish(String(data=text))

    def session_ended(self, report: Report) -> None:
        self._statuses.publish(self._status_array(report))

    def _create(self, name: str, type: str, qos: Qos) -> Publisher:
        package, _, message = type.partition("/msg/")
        return self._node.create_publisher(
            getattr(importlib.import_module(f"{package}.msg"), message),
            name,
            QoSProfile(
                history=HistoryPolicy.KEEP_LAST,
                depth=qos.depth,
                reliability=ReliabilityPolicy.RELIABLE,
                durability=DurabilityPolicy[qos.durability.upper()],
            ),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _status_array(self, report: Report | None) -> DiagnosticArray:
        with self._lock:
            rows = self._diagnostics.rows(report, time.monotonic())
            subscribers = {
                topic.full_name(self._prefix): {
                    "subscribers": str(publisher.get_subscription_count())
                }
                for topic, publisher in self._publishers.items()
            }
        array = DiagnosticArray(
            status=[_status(row, subscribers.get(row.name, {})) for row in rows]
        )
        array.header.stamp = self._node.get_clock().now().to_msg()
        return array


def _refuse(_: bytearray) -> None:
    raise PublishError("the topic could not be made")


def _status(row: Row, more: dict[str, str]) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=bytes([row.level]),
        name=f"ml2_receiver: {row.name}",
        message=row.message,
        hardware_id="magic_leap_2",
        values=[KeyValue(key=key, value=value) for key, value in (row.values | more).items()],
    )


def takes_bytearray(publisher: Publisher, message: Any) -> bool:
    """Whether this rclpy publishes a bytearray as it is, tried with `message`."""
    try:
        publisher.handle.publish_raw(bytearray(serialize_message(message)))
    except (AttributeError, TypeError):
        return False
    return True


def raw_publish(publisher: Publisher, is_bytearray_taken: bool) -> Publish:
    """A function that publishes payloads; rclpy's own publish() would have them copied to bytes."""
    handle = publisher.handle
    publish_raw: Callable[[bytearray], None] = (
        handle.publish_raw
        if is_bytearray_taken
        else lambda payload: publisher.publish(bytes(payload))
    )

    def publish(payload: bytearray) -> None:
        try:
            with handle:
                publish_raw(payload)
        except InvalidHandle:
            pass  # the topic ended while this was under way
        except rclpy_implementation.RCLError as error:
            raise PublishError(str(error)) from error

    return publish
