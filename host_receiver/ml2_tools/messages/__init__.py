"""Generates classes of ROS 2 message types for apps, from the descriptions that ROS installs."""
