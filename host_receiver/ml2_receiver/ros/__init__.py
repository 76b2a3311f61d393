"""The receiver as a ROS 2 node; all of it that imports rclpy, but for `ml2-receiver latency`."""

from .node import RosNode as RosNode
