"""Sinks in front of others, judgements of streams, and the receiver's own topics."""
