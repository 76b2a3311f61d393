"""Recordings: MCAP files in rosbag2 folders, written straight from payloads."""
