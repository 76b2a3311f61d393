"""ml2-receiver config: what a configuration can say, and what one asks the headset for."""

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from ..configuration.config import Config, load_each
from ..configuration.forecast import images_mbit_per_s
from ..configuration.link_fit import bound_mbit_per_s, fitting_change, link_in_words
from ..json_text import json_text
from ..table.reader import load_table
from ..table.stream_table import Topic
from .options import Subparsers, above_zero, add_file
from .receiving import print_ignored

_CHECK_EPILOG = """\
Checks a file with several receivers for each of them. --json then has an object for each, by the
name of its node.
Exit code: 0, or 2 with one line per wrong value.

examples:
  ml2-receiver config check my.yaml
  ml2-receiver config check my.yaml --link 100     and what would fit a link of 100 Mbit/s
  ml2-receiver config check my.yaml --json | jq -r '.streams[].topics[]'
  ml2-receiver config check my.yaml --json | jq .mbit_per_s     what the images need of the link
"""
_SHOW_EPILOG = """\
examples:
  ml2-receiver config show
  ml2-receiver config show --json | jq '.depth.modes'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser("config", help="work with configuration files")
    actions = parser.add_subparsers(required=True, metavar="ACTION")
    check = actions.add_parser(
        "check",
        help="say what is wrong in a file, or what it starts and needs",
        epilog=_CHECK_EPILOG,
    )
    add_file(check, "file", metavar="FILE", help="a ROS 2 parameter file")
    check.add_argument(
        "--link",
        type=above_zero,
        metavar="MBIT",
        help="what the link carries, in Mbit/s; default: general.link, if it is a number",
    )
    check.add_argument("--json", action="store_true", help="print one object")
    check.set_defaults(run=_check)
    show = actions.add_parser(
        "show", help="list every stream with its legal values", epilog=_SHOW_EPILOG
    )
    show.add_argument("--json", action="store_true", help="print one object, by stream")
    show.set_defaults(run=_show)


# rich is imported where a table is printed, as all commands import this module.
def _check(options: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.table import Table

    configs = load_each(options.file)
    ignored = dict.fromkeys(it for config in configs.values() for it in config.ignored)
    print_ignored(ignored, str(options.file))
    if options.json:
        each = {node: _as_json(it, options.link) for node, it in configs.items()}
        print(json_text(each if len(each) > 1 else next(iter(each.values())), indent=2))
        return 0
    for node, config in configs.items():
        # Not the table's title, which would break the command to copy into lines
        whose = f"{node}: " if len(configs) > 1 else ""
        needs, link = _needs(config, options.link)
        said = link_in_words(config, needs, link)
        print(f"{whose}{len(config.requests)} streams; {said}", flush=True)
        table = Table("stream", "topics")
        table.add_column("Mbit/s", justify="right")
        for id, _, topics in _streams(config):
            need = f"{needs[id]:.1f}" if id in needs else ""
            table.add_row(id, "\n".join(it.full_name(config.prefix) for it in topics), need)
        Console().print(table)
    return 0


def _needs(config: Config, link: float | None) -> tuple[Mapping[str, float], float | None]:
    """Returns what images need by stream, and what the link carries, in Mbit/s."""
    return images_mbit_per_s(config), link or bound_mbit_per_s(config)


def _as_json(config: Config, link: float | None) -> dict[str, Any]:
    """Returns an object; `change` is null where the link is not known, or nothing fits it."""
    needs, link = _needs(config, link)
    change = None if link is None else fitting_change(config, link, needs)
    return {
        "prefix": config.prefix,
        "mbit_per_s": round(sum(needs.values()), 2),
        "link_mbit_per_s": link,
        "change": None if change is None else change.values,
        "streams": {
            id: {
                "values": values,
                "topics": [it.full_name(config.prefix) for it in topics],
                "mbit_per_s": round(needs[id], 2) if id in needs else None,
            }
            for id, values, topics in _streams(config)
        },
    }


def _streams(config: Config) -> Iterator[tuple[str, dict[str, Any], list[Topic]]]:
    """Each stream that will run, its values, and its topics."""
    for id, values in config.requests.items():
        topics = load_table().streams[id].topics
        yield id, dict(values), [it for it in topics if it.when is None or it.when.holds(values)]


def _show(options: argparse.Namespace) -> int:
    from rich.console import Console

    from ..configuration.stream_options import options_of, options_table, other_options

    streams = options_of(load_table())
    if options.json:
        print(json_text(streams, indent=2))
    else:
        Console().print(options_table(streams, other_options(load_table())))
    return 0
