"""The receiver as a ROS 2 node; with the modules of `ml2-receiver latency`, all that imports rclpy."""

from .node import RosNode

__all__ = ["RosNode"]
