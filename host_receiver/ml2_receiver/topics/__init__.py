"""The interface of sinks, sinks in front of others, and the receiver's own topics."""
