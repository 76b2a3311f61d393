"""Pixels of image messages, and their rectification."""
