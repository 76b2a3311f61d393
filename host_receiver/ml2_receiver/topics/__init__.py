"""Sinks in front of others, whether streams deliver, and the receiver's own topics."""
