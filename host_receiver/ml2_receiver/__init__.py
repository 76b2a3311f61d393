"""Receives the sensor streams of a Magic Leap 2 headset and publishes them as ROS 2 topics."""
