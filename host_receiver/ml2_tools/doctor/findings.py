"""The judgements of `ml2-receiver doctor`: pure functions of what was read, one finding each."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from ml2_receiver.processes import Process, is_receiver
from ml2_receiver.ros.fastdds import NEEDED_BYTES, PROFILES_VARIABLE
from ml2_receiver.topics.judgement import read_judgements
from ml2_receiver.transport.discovery import FoundReceiver

# https://docs.ros.org/en/jazzy/How-To-Guides/DDS-tuning.html asks for as much as there is; several
# images of 1 MB under way need this.
_RECEIVE_BUFFER_BYTES = 4 * 1024 * 1024
_PYTHON = (3, 12)
_NODE = "ml2_receiver"
_DOMAIN = "ROS_DOMAIN_ID"
_NO_STREAM = (
    "mend what the reason says; what waits comes back by itself. Else ask for other values, or"
    " disable the stream"
)


type Level = Literal["ok", "hint", "wrong"]


@dataclass(frozen=True)
class Finding:
    """One thing looked at. "wrong" keeps the receiver from working, "hint" may matter to some.

    `fix` says what to do, and is empty when all is well. `numbers` has what was measured, by name
    with its unit.
    """

    check: str
    level: Level
    found: str
    fix: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)


def python(version: tuple[int, ...]) -> Finding:
    found = ".".join(map(str, version[:3]))
    if version[:2] >= _PYTHON:
        return Finding("Python", "ok", found)
    return Finding("Python", "wrong", found, "use Python 3.12, as ROS 2 Jazzy does")


def ros(distribution: str | None, missing: Collection[str]) -> Finding:
    if missing:
        fix = "source /opt/ros/jazzy/setup.bash, or run make setup"
        return Finding("ROS 2", "wrong", f"Python does not find {', '.join(missing)}", fix)
    if distribution not in (None, "jazzy"):
        found = f"{distribution} is sourced"
        return Finding("ROS 2", "wrong", found, "open a terminal in which only Jazzy is sourced")
    return Finding("ROS 2", "ok", "Jazzy" if distribution else "found by Python")


def fast_dds_profile(environment: Mapping[str, str], *, is_in_working_directory: bool) -> Finding:
    check = "Fast DDS profile"
    middleware = environment.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    if not middleware.startswith("rmw_fastrtps"):
        if middleware.startswith("rmw_zenoh"):
            return Finding(check, "ok", f"{middleware} is used, which needs none")
        return Finding(check, "hint", f"{middleware} is used", "it has not been tried with images")
    own = environment.get(PROFILES_VARIABLE) or (
        "DEFAULT_FASTRTPS_PROFILES.xml" if is_in_working_directory else None
    )
    if own is None:
        return Finding(check, "ok", "`run` applies its own")
    fix = f"give it a segment_size of 64 MiB, or unset {PROFILES_VARIABLE}"
    return Finding(check, "hint", f"{own} is used instead of the receiver's", fix)


def shared_memory(free_bytes: int) -> Finding:
    found = f"{free_bytes / 1e6:.0f} MB free in /dev/shm"
    if free_bytes >= NEEDED_BYTES:
        return Finding("shared memory", "ok", found)
    fix = (
        f"make it {NEEDED_BYTES / 1e6:.0f} MB or more: sudo mount -o remount,size=512M /dev/shm,"
        " or docker run --shm-size=512m"
    )
    return Finding("shared memory", "wrong", found, fix)


def udp_buffer(bytes_max: int | None) -> Finding:
    found = "unknown" if bytes_max is None else f"net.core.rmem_max = {bytes_max}"
    if bytes_max is not None and bytes_max >= _RECEIVE_BUFFER_BYTES:
        return Finding("UDP buffers", "ok", found)
    fix = (
        "subscribers on other machines lose images:"
        f" sudo sysctl -w net.core.rmem_max={_RECEIVE_BUFFER_BYTES}"
    )
    return Finding("UDP buffers", "hint", found, fix)


def port(number: int, holder: Process | None, *, is_listened_on: bool) -> Finding:
    check = f"port {number}"
    if not is_listened_on:
        return Finding(check, "ok", "free")
    if holder is not None and is_receiver(holder.command):
        return Finding(check, "ok", f"a receiver listens, pid {holder.pid}")
    who = "a process of another user" if holder is None else str(holder)
    return Finding(check, "wrong", f"taken by {who}", "end it, or run with --listen HOST:PORT")


def firewall(name: str | None, port: int) -> Finding:
    fixes = {
        "ufw": f"sudo ufw allow {port}/tcp && sudo ufw allow 5353/udp",
        "firewalld": f"sudo firewall-cmd --add-port={port}/tcp --add-service=mdns",
    }
    if name is None:
        return Finding("firewall", "ok", "neither ufw nor firewalld is on")
    return Finding("firewall", "hint", f"{name} is on", f"unless done: {fixes[name]}")


def multicast(found: Sequence[FoundReceiver] | str) -> Finding:
    """Judges multicast by the receivers found, or by the reason why the search failed."""
    if isinstance(found, str):
        fix = "give headsets the address, or connect to a network that has multicast"
        return Finding("mDNS", "wrong", found, fix)
    receivers = (f"{it.name} at {', '.join(it.addresses)}, port {it.port}" for it in found)
    return Finding("mDNS", "ok", "; ".join(receivers) or "works; no receiver announces itself")


def clock(is_synchronised: bool) -> Finding:
    if is_synchronised:
        return Finding("clock", "ok", "synchronised")
    fix = "needed with other machines in the graph: sudo timedatectl set-ntp true, or chrony"
    return Finding("clock", "hint", "nobody synchronises it", fix)


def domain(here: str | None, receivers: Mapping[int, str | None]) -> Finding:
    """Compares this terminal's ROS_DOMAIN_ID with those of running receivers, by pid; None is 0."""
    own = here or "0"
    domains = {pid: value or "0" for pid, value in receivers.items()}
    if not domains or own in domains.values():
        return Finding("ROS domain", "ok", own)
    pid, other = next(iter(domains.items()))
    found = f"{own} in this terminal, {other} in the running receiver, pid {pid}"
    return Finding("ROS domain", "wrong", found, f"export {_DOMAIN}={other}")


def streams(rows: Mapping[str, Mapping[str, str]]) -> Finding | None:
    """Names the enabled streams that deliver nothing; None without a connected headset."""
    session = rows.get("session", {})
    if session.get("state") != "connected":
        return None
    judgements = read_judgements(session)
    wrong = {id: it for id, it in judgements.items() if it.is_wrong}
    if not wrong:
        running = sum(it.state == "running" for it in judgements.values())
        return Finding("streams", "ok", f"{running} run")
    found = "; ".join(f"{id}: {it.text}" for id, it in wrong.items())
    grants = [
        f"{it.permission}, by `ml2-receiver headset grant {id}`"
        for id, it in wrong.items()
        if it.permission is not None
    ]
    fix = f"grant {'; '.join(grants)}" if grants else _NO_STREAM
    return Finding("streams", "wrong", found, fix)


def wrong_parameter_file(file: str, problems: str) -> Finding:
    """Reports the problems for which `run --config` refuses a file."""
    fix = f"correct the file; `ml2-receiver config check {file}` says what is still wrong"
    return Finding("configuration", "wrong", problems, fix)


def parameter_file(file: str, nodes: Sequence[str]) -> Finding:
    """Judges by the node names in a file whether ROS's own --params-file would use it too."""
    check = "configuration"
    if any(name.rpartition("/")[2] in (_NODE, "**", "*") for name in nodes):
        return Finding(check, "ok", f"{file} is well")
    found = f"{file} is for the node {nodes[0]}"
    fix = (
        f"load it with `ml2-receiver run --config {file}`: ROS's --params-file applies to the node"
        f" {_NODE} only what stands under /{_NODE} or /**"
    )
    return Finding(check, "hint", found, fix)
