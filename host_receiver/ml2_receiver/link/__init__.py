"""Connections, sessions and what runs in them: the receiver as headsets see it."""
