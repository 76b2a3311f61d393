"""ml2-receiver config: what a configuration file asks the headset for."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ..config import Config, load_config
from ..table import load_table

type Subparsers = argparse._SubParsersAction[argparse.ArgumentParser]


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser("config", help="work with configuration files")
    actions = parser.add_subparsers(required=True, metavar="ACTION")
    check = actions.add_parser("check", help="say what is wrong in a file, or what it will start")
    check.add_argument("file", type=Path, metavar="FILE")
    check.set_defaults(run=_check)


def _check(options: argparse.Namespace) -> int:
    Console().print(_streams(load_config(options.file)))
    return 0


def _streams(config: Config) -> Table:
    table = Table("stream", "topics", title=f"{len(config.requests)} streams", title_justify="left")
    for id, values in config.requests.items():
        names = [
            topic.full_name(config.prefix)
            for topic in load_table().streams[id].topics
            if topic.when is None or topic.when.holds(values)
        ]
        table.add_row(id, "\n".join(names))
    return table
