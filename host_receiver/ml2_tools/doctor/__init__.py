"""Finds what prevents a receiver on this machine from working."""
