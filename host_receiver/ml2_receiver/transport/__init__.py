"""Listening sockets, plaintext and TLS connections, and discovery."""
