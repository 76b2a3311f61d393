"""Nodes that read the topics of a running receiver, and ask its services."""
