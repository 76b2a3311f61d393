"""Plays a recording to a receiver as a headset would: the device's side of PROTOCOL.md."""
