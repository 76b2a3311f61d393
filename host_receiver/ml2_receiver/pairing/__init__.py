"""Pairing of a headset with this receiver."""
