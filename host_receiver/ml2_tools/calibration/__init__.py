"""Estimates from recordings how inertial units are mounted on the head."""
