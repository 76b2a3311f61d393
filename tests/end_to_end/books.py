"""Whether a headset's books and those of its receiver agree."""

from __future__ import annotations

from processes import Received


def assert_books_balance(received: Received) -> None:
    """Every message of every topic arrived, or was dropped for a reason; some did arrive."""
    for topic, seen in received.snapshot["topics"].items():
        books = received.books(topic)
        dropped = sum(int(n) for key, n in books.items() if key.startswith("dropped."))
        assert int(books["produced"]) == int(books["received"]) + int(books["gaps"]), topic
        assert int(books["gaps"]) == dropped, topic
        assert 0 < seen["count"] <= int(books["received"]), topic
