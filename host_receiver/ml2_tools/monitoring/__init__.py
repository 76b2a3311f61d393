"""Reads the topics and diagnostics of running receivers."""
