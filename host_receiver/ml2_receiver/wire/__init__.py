"""Bytes <-> frames and control bodies, as PROTOCOL.md has them."""
