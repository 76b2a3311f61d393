"""Checks a recording: stamps, pairs, coverage, timing."""
