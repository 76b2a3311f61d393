"""Prints benchmark results: one table of load runs, and one of all other benchmarks."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table


def main(paths: list[Path]) -> None:
    """Prints the results in JSON files; those of full_load.py have a row per headset.

    A file with a list, which `make links` writes, is left out.
    """
    measures = Table("benchmark", "measure", "value", title="build/bench")
    loads = Table("load", "drops", "at the start", "slowest p99 ms", "CPU % of", title="load")
    for path in paths:
        results = json.loads(path.read_text())
        if not isinstance(results, dict):
            continue
        headsets = {path.stem: results, **results}
        rows = {name: it for name, it in headsets.items() if _is_load(it)}
        for name, load in rows.items():
            loads.add_row(name, *_load(load))
        for index, (measure, value) in enumerate([] if rows else _leaves(results)):
            measures.add_row(path.stem if index == 0 else "", measure, _text(value))
    for table in (measures, loads):
        Console().print(table)


def _is_load(results: Any) -> bool:
    return isinstance(results, dict) and results.keys() >= {"drops", "latency_ms", "cpu_percent"}


def _load(load: dict[str, Any]) -> tuple[str, ...]:
    latencies = (_slowest(load["latency_ms"][phase]) for phase in ("start", "steady"))
    cpu = ", ".join(f"{role} {_text(value)}" for role, value in load["cpu_percent"].items())
    return str(load["drops"]), *latencies, cpu


def _slowest(latency_ms: dict[str, dict[str, float]]) -> str:
    stream, latency = max(latency_ms.items(), key=lambda item: item[1]["p99"])
    return f"{_text(latency['p99'])} ({stream})"


def _leaves(results: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in results.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main([Path(argument) for argument in sys.argv[1:]])
