"""Estimates a camera's trajectory from its images and compares it with the headset's poses."""
