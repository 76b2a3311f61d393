"""ml2-receiver doctor: what keeps a receiver on this machine from working, and what to do."""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from ml2_receiver.commands.options import Subparsers, add_file, add_receiver
from ml2_receiver.commands.session_port import PORT
from ml2_receiver.configuration.config import Config, load_each
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.configuration.parameter_file import MAX_BYTES, node_names
from ml2_receiver.configuration.settings import config_of
from ml2_receiver.configuration.whole_file import read_file
from ml2_receiver.errors import ConfigError, DiscoveryError, RosError
from ml2_receiver.json_text import json_text
from ml2_receiver.printable import markup
from ml2_receiver.processes import is_listened_on, listener_of, receivers
from ml2_receiver.ros.fastdds import free_shared_memory_bytes
from ml2_receiver.table.reader import load_table
from ml2_receiver.transport.discovery import FoundReceiver, find_receivers

from ..doctor import bundle, findings, machine
from ..doctor.delivery import delivery
from ..doctor.findings import Finding
from ..doctor.link_finding import link_finding
from .live import PATIENCE_S, diagnostics_node

if TYPE_CHECKING:
    from ..live.diagnostics import Values
    from ..live.diagnostics_node import DiagnosticsNode

_MARKS = {"ok": "[green]ok[/]", "hint": "[yellow]hint[/]", "wrong": "[red]wrong[/]"}
_EPILOG = """\
The link to a headset that is connected is tried for about 2 s, beside its streams.
Exit code: 0, or 1 when anything is "wrong"; a "hint" may not matter to you.

examples:
  ml2-receiver doctor
  ml2-receiver doctor my.yaml        look at a configuration file, too
  ml2-receiver doctor --name robot1  the link to the headset of that receiver
  ml2-receiver doctor --bundle report.zip   what to attach to a report
  ml2-receiver doctor --json | jq '.[] | select(.level == "wrong")'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "doctor",
        help="find out why something does not work, and what to do",
        epilog=_EPILOG,
    )
    add_file(parser, "file", nargs="?", metavar="FILE", help="a configuration file")
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    add_file(
        parser,
        "--bundle",
        metavar="ZIP",
        help="also write versions, configuration, diagnostics, logs and findings to a zip file,"
        " without keys and images",
    )
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    found = list(_findings(options))
    if options.json:
        print(json_text([dataclasses.asdict(it) for it in found], indent=2))
    else:
        Console().print(_table(found))
    if options.bundle is not None:
        bundle.write_bundle(options.bundle, _bundled(options, found))
        print(f"wrote {options.bundle}: attach it to the report", file=sys.stderr)
    return int(any(it.level == "wrong" for it in found))


def _findings(options: argparse.Namespace) -> Iterator[Finding]:
    file: Path | None = options.file
    yield findings.python(sys.version_info[:3])
    yield findings.ros(os.environ.get("ROS_DISTRO"), machine.missing_modules())
    yield findings.fast_dds_profile(
        os.environ, is_in_working_directory=Path("DEFAULT_FASTRTPS_PROFILES.xml").exists()
    )
    yield findings.shared_memory(free_shared_memory_bytes())
    yield findings.udp_buffer(machine.kernel_number("net.core.rmem_max"))
    yield findings.port(PORT, listener_of(PORT), is_listened_on=is_listened_on(PORT))
    yield findings.firewall(machine.firewall(), PORT)
    yield findings.multicast(_announced())
    with suppress(OSError):  # a sandbox that forbids to ask
        yield findings.clock(machine.is_clock_synchronised())
    running = {it.pid: it.environment("ROS_DOMAIN_ID") for it in receivers()}
    domain = os.environ.get("ROS_DOMAIN_ID")
    yield findings.domain(domain, running)
    is_running = any((it or "0") == (domain or "0") for it in running.values())
    if is_running:
        yield from _headset(options.name)
    else:
        yield link_finding("no receiver runs here", "")
    if file is not None:
        yield _parameter_file(file)


def _bundled(options: argparse.Namespace, found: Sequence[Finding]) -> Mapping[str, str]:
    """Returns the texts of a bundle by their names in it."""
    config = ConfigFile(options.file) if options.file else ConfigFile.of_user()
    text = "The packaged configuration is used.\n"
    texts = {
        "versions.json": bundle.as_json(bundle.versions(os.environ)),
        "findings.json": bundle.as_json([dataclasses.asdict(it) for it in found]),
        "configuration.yaml": text if config.is_packaged else bundle.text_of(config.path),
        "diagnostics.json": bundle.as_json(_diagnostics(options.name)),
    }
    logs = bundle.receiver_logs(bundle.log_folder(os.environ))
    return texts | {f"logs/{log.name}": bundle.text_of(log) for log in logs}


def _diagnostics(receiver: str) -> Mapping[str, Values | str]:
    """Returns the rows of the last /diagnostics, or the reason why there are none."""
    if not receivers():
        return {"error": "no receiver runs here"}
    try:
        with diagnostics_node() as node:
            return node.rows(receiver, PATIENCE_S)
    except RosError as error:
        return {"error": str(error)}


def _parameter_file(file: Path) -> Finding:
    try:
        load_each(file)
        data = read_file(file, MAX_BYTES)
    except ConfigError as error:
        return findings.wrong_parameter_file(str(file), str(error))
    except OSError as error:  # it has just changed
        return findings.wrong_parameter_file(str(file), error.strerror or str(error))
    return findings.parameter_file(str(file), node_names(data))


def _announced() -> Sequence[FoundReceiver] | str:
    try:
        return find_receivers()
    except DiscoveryError as error:
        return str(error)


def _headset(receiver: str) -> Iterator[Finding]:
    try:
        trying = Console(stderr=True).status("trying the link to the headset")
        with diagnostics_node() as node, trying:
            rows = node.rows(receiver, PATIENCE_S)
            streams = findings.streams(rows)
            test = "" if streams is None else _tested(node, receiver)
            config = None if streams is None else _config(node, receiver)
    except RosError as error:
        yield link_finding(str(error), "")
    else:
        yield link_finding(rows, test, config)
        if streams is not None:
            yield streams
        yield from delivery(rows)


def _tested(node: DiagnosticsNode, receiver: str) -> Values | str:
    from ..doctor.link_test import try_link

    try:
        return try_link(node, receiver)
    except RosError as error:
        return str(error)


def _config(node: DiagnosticsNode, receiver: str) -> Config | None:
    """Returns the configuration in force, or None if the receiver does not tell it."""
    from ..live.receiver_client import ReceiverClient

    sections = load_table().sections.values()
    names = [f"{section.id}.{key}" for section in sections for key in section.keys]
    try:
        with closing(
            ReceiverClient(node.context, node.node_name(receiver, PATIENCE_S), PATIENCE_S)
        ) as client:
            values = client.get(names)
        return dataclasses.replace(config_of(values), name=receiver) if values else None
    except (ConfigError, RosError):
        return None


def _table(found: Sequence[Finding]) -> Table:
    table = Table("", "check", "found", "what to do", box=None)
    for it in found:
        table.add_row(_MARKS[it.level], it.check, markup(it.found), markup(it.fix))
    return table
