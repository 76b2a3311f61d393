"""Gives Fast DDS enough shared memory for images, where some are sent.

With its default segment of 512 KiB an image of 1 MB at 90 Hz loses more than half of its messages
on the way to a best-effort subscriber; with 64 MiB it loses none.
"""

import atexit
import fcntl
import os
import tempfile
from collections.abc import MutableMapping
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree

# The only name Fast DDS 2 reads, and the file it reads from the working directory.
PROFILES_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
# The packaged profile names it.
SEGMENT_VARIABLE = "ML2_RECEIVER_SEGMENT_BYTES"
_WORKING_DIRECTORY_PROFILE = Path("DEFAULT_FASTRTPS_PROFILES.xml")

_SHARED_MEMORY = Path("/dev/shm")
# A lock of the memory of a participant, which has the same name without the end
_LOCKS = f"fastrtps_{'[0-9a-f]' * 16}_el"
NEEDED_BYTES = 80_000_000
_IMAGES_SEGMENT_BYTES = 64 << 20
# That of Fast DDS. What others send is in their segments. A participant writes all of its own when
# it starts, which takes 80 ms of a processor for 64 MiB.
SMALL_SEGMENT_BYTES = 512 << 10
# A smaller segment hardly holds an image, and takes the memory that other nodes' ports need:
# a node whose ports find none is not ended by a signal.
_LEAST_SEGMENT_BYTES = 4_000_000
# Fast DDS reads no prefixes of namespaces, so this one is written without.
ElementTree.register_namespace("", "http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles")


def apply_default_profile(environ: MutableMapping[str, str], *, sends_images: bool) -> str | None:
    """Makes Fast DDS use this package's profile, unless the user has chosen one.

    Removes the shared memory that this user's killed participants have left.
    Fast DDS reads `environ` when its first participant is made: call this before rclpy.init.

    Args:
        sends_images: takes shared memory for them, too.

    Returns:
        A warning when there is too little shared memory for it, and less is used.
    """
    if not environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").startswith("rmw_fastrtps"):
        return None
    if environ.get(PROFILES_VARIABLE) or _WORKING_DIRECTORY_PROFILE.exists():
        return None
    _remove_memory_of_killed_participants()
    profile = resources.files("ml2_receiver").joinpath("data/fastdds_profile.xml")
    free_bytes = free_shared_memory_bytes()
    segment_bytes = wanted_bytes = _IMAGES_SEGMENT_BYTES if sends_images else SMALL_SEGMENT_BYTES
    if free_bytes < NEEDED_BYTES:
        # Half, as the subscribers' own Fast DDS needs some too.
        segment_bytes = min(wanted_bytes, free_bytes // 2)
    has_segment = free_bytes // 2 >= _LEAST_SEGMENT_BYTES
    environ[SEGMENT_VARIABLE] = str(segment_bytes)
    environ[PROFILES_VARIABLE] = (
        str(profile)
        if has_segment
        else _write_temporary(_without_shared_memory(profile.read_text("utf-8")))
    )
    if has_segment and segment_bytes == wanted_bytes:
        return None
    gets = f"gets {segment_bytes / 1e6:.1f} MB" if has_segment else "uses UDP alone"
    return (
        f"{_SHARED_MEMORY} has {free_bytes / 1e6:.1f} MB free,"
        f" expected {NEEDED_BYTES / 1e6:.0f} MB:"
        f" Fast DDS {gets} and subscribers may miss images."
        " In a container, raise --shm-size."
    )


def free_shared_memory_bytes() -> int:
    """Returns the free bytes of shared memory; 0 if there is none."""
    try:
        memory = os.statvfs(_SHARED_MEMORY)
    except FileNotFoundError:
        return 0
    return memory.f_bavail * memory.f_frsize


def _remove_memory_of_killed_participants() -> None:
    """Does what `fastdds shm clean` does for the memory of participants, 70 MB with this profile.

    A participant locks its file before it makes the memory, and keeps the lock while it lives.
    """
    for lock in _SHARED_MEMORY.glob(_LOCKS):
        memory = lock.with_name(lock.name.removesuffix("_el"))
        try:
            if {lock.lstat().st_uid, memory.lstat().st_uid} != {os.geteuid()}:
                continue
            with lock.open("rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                memory.unlink()
                lock.unlink()
        except (BlockingIOError, FileNotFoundError):
            continue  # it lives, or has begun or ended this moment


def _without_shared_memory(profile: str) -> ElementTree.Element:
    root = ElementTree.fromstring(profile)
    (transports,) = root.iterfind(".//{*}userTransports")
    (shared_memory,) = (it for it in transports if it.text == "shared_memory")
    transports.remove(shared_memory)
    return root


def _write_temporary(profile: ElementTree.Element) -> str:
    """Writes a file that lives as long as this process: every participant reads it again."""
    with tempfile.NamedTemporaryFile(prefix="ml2_receiver_", suffix=".xml", delete=False) as file:
        ElementTree.ElementTree(profile).write(file, encoding="utf-8", xml_declaration=True)
    atexit.register(Path(file.name).unlink, missing_ok=True)
    return file.name
