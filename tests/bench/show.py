"""Prints benchmark results, one table for all files given."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table


def main(paths: list[Path]) -> None:
    """Shows each JSON object as rows of measure and value."""
    table = Table("benchmark", "measure", "value", title="build/bench")
    for path in paths:
        results = json.loads(path.read_text())
        for index, (measure, value) in enumerate(results.items()):
            shown = f"{value:.4g}" if isinstance(value, float) else str(value)
            table.add_row(path.stem if index == 0 else "", measure, shown)
    Console().print(table)


if __name__ == "__main__":
    main([Path(argument) for argument in sys.argv[1:]])
