"""Shows the progress of reading a recording."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from ..bags.bag_reader import Bag


@contextmanager
def progress(bag: Bag, label: str) -> Iterator[Callable[[int], None]]:
    """Shows a bar on stderr; yields a function to call with the length of each payload."""
    columns = TextColumn(label), BarColumn(), TaskProgressColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=bag.size_bytes)
        yield lambda size: bar.advance(task, size)
