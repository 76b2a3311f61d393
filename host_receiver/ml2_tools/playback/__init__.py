"""Plays a recording to a receiver as a headset would; implements the device side of PROTOCOL.md."""
