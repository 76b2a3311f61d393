"""How far the reading of a recording is."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from ..bags.bag_reader import Bag


@contextmanager
def progress(bag: Bag, doing: str) -> Iterator[Callable[[int], None]]:
    """A bar on stderr, of what is given the length of each payload that was read."""
    columns = TextColumn(doing), BarColumn(), TaskProgressColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=bag.size_bytes)
        yield lambda size: bar.advance(task, size)
