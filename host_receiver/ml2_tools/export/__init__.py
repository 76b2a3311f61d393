"""Calibration for programs that do not read ROS topics."""
