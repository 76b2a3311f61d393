"""Publishes the topics of the thesis's scripts, for programs that use them."""
