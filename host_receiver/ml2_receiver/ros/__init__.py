"""The receiver as a ROS 2 node. Only this package and ml2_tools import rclpy."""
