"""Judges from recordings what is assumed about the headset."""
