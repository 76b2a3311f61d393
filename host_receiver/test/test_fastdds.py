import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from string import Template
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from ml2_receiver.ros import fastdds
from ml2_receiver.ros.fastdds import PROFILES_VARIABLE, apply_default_profile
from ros_domain import reserve_domain
from ros_processes import Child, environment, segments
from waiting import LIMIT_S

MEBIBYTE = 2**20
# So many participants of a domain get no shared memory; a second one may still be ending.
_BLOCKED = 4
NAMESPACE = "{http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles}"


@pytest.fixture
def free_memory(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    memory = SimpleNamespace(f_bavail=24 * 2**30, f_frsize=1)
    monkeypatch.setattr(os, "statvfs", lambda path: memory)
    return memory


def segment_bytes(environ: dict[str, str]) -> int:
    root = ElementTree.parse(environ[PROFILES_VARIABLE]).getroot()
    size = root.findtext(f".//{NAMESPACE}segment_size", "")
    return int(Template(size).substitute(environ))


@pytest.mark.usefixtures("free_memory")
def test_fast_dds_gets_64_mebibytes_for_images_where_there_is_room() -> None:
    environ: dict[str, str] = {}
    assert apply_default_profile(environ, sends_images=True) is None
    assert segment_bytes(environ) == 64 * MEBIBYTE


@pytest.mark.parametrize("free", [8_000_000, 24 * 2**30])
def test_fast_dds_gets_its_half_mebibyte_without_images(
    free_memory: SimpleNamespace, free: int
) -> None:
    free_memory.f_bavail = free
    environ: dict[str, str] = {}
    assert apply_default_profile(environ, sends_images=False) is None
    assert segment_bytes(environ) == MEBIBYTE // 2


@pytest.mark.parametrize(
    ("variable", "value"),
    [(PROFILES_VARIABLE, "mine.xml"), ("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")],
)
def test_what_the_user_has_chosen_stays(variable: str, value: str) -> None:
    environ = {variable: value}
    assert apply_default_profile(environ, sends_images=True) is None
    assert environ == {variable: value}


def test_a_profile_in_the_working_directory_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("DEFAULT_FASTRTPS_PROFILES.xml").touch()
    environ: dict[str, str] = {}
    apply_default_profile(environ, sends_images=True)
    assert environ == {}


@pytest.mark.parametrize(
    ("free", "segment"),
    [(64 * MEBIBYTE, 32 * MEBIBYTE), (79_999_999, 39_999_999), (8_000_000, 4_000_000)],
)
def test_little_shared_memory_makes_a_smaller_segment_and_a_warning(
    free_memory: SimpleNamespace, free: int, segment: int
) -> None:
    free_memory.f_bavail = free
    environ: dict[str, str] = {}
    warning = apply_default_profile(environ, sends_images=True)
    assert warning is not None
    assert f"{free / 1e6:.1f} MB free, expected 80 MB" in warning
    assert segment_bytes(environ) == segment


@pytest.mark.parametrize("free", [0, 7_999_999])
@pytest.mark.parametrize("sends_images", [True, False])
def test_where_no_image_fits_none_of_the_shared_memory_is_used(
    free_memory: SimpleNamespace, free: int, sends_images: bool
) -> None:
    free_memory.f_bavail = free
    environ: dict[str, str] = {}
    warning = apply_default_profile(environ, sends_images=sends_images)
    assert "Fast DDS uses UDP alone" in (warning or "")
    root = ElementTree.parse(environ[PROFILES_VARIABLE]).getroot()
    used = root.iterfind(f".//{NAMESPACE}userTransports/{NAMESPACE}transport_id")
    assert [it.text for it in used] == ["udp"]


def test_no_shared_memory_at_all_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(path: str) -> None:
        raise FileNotFoundError(path)

    monkeypatch.setattr(os, "statvfs", missing)
    assert "0.0 MB free" in (apply_default_profile({}, sends_images=True) or "")


PARTICIPANT = """
import os
import sys
from ml2_receiver.ros import fastdds
if "free" in sys.argv:
    fastdds.free_shared_memory_bytes = lambda: int(sys.argv[-1])
fastdds.apply_default_profile(os.environ, sends_images="images" in sys.argv)
import rclpy
rclpy.init()
node = rclpy.create_node("profile_probe")
print("ready", flush=True)
sys.stdin.read()
node.destroy_node()
rclpy.shutdown()
"""


@pytest.fixture
def no_profile(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a process starts in which ROS has not started."""
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    monkeypatch.delenv(PROFILES_VARIABLE, raising=False)


@pytest.mark.usefixtures("no_profile")
@pytest.mark.parametrize(
    ("arguments", "least", "most"),
    [
        (["images"], 64 * MEBIBYTE, 80_000_000),
        (["images", "free", "40000000"], 20_000_000, 30_000_000),
        ([], MEBIBYTE // 2, 2 * MEBIBYTE),
    ],
    ids=["for images", "for images with little memory", "without images"],
)
def test_a_participant_makes_the_segment(arguments: list[str], least: int, most: int) -> None:
    memory = os.statvfs("/dev/shm")
    if memory.f_bavail * memory.f_frsize < 80_000_000:
        pytest.skip("/dev/shm has less than 80 MB free")
    with Child("-c", PARTICIPANT, *arguments) as child:
        assert child.line() == "ready"
        assert least < max(it.stat().st_size for it in segments(child.process.pid)) < most


@pytest.mark.usefixtures("no_profile")
@pytest.mark.parametrize(("free", "maps"), [("100000000", True), ("1000000", False)])
def test_a_participant_maps_no_shared_memory_where_no_image_fits(free: str, maps: bool) -> None:
    does_map = "'/dev/shm/fastrtps_' in open('/proc/self/maps').read()"
    run = subprocess.run(
        [sys.executable, "-c", PARTICIPANT.replace('"ready"', does_map), "free", free],
        # In the range of the other tests, rmw_fastrtps adds a default segment to any profile.
        env=environment() | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"},
        input="",
        capture_output=True,
        check=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert run.stdout == f"{maps}\n"
    assert run.stderr == ""


@pytest.mark.usefixtures("no_profile")
def test_the_memory_of_a_killed_participant_is_removed_and_that_of_a_living_one_stays() -> None:
    with Child("-c", PARTICIPANT) as living, Child("-c", PARTICIPANT) as killed:
        assert [living.line(), killed.line()] == ["ready", "ready"]
        kept, left = segments(living.process.pid), segments(killed.process.pid)
        assert kept
        assert left
        killed.process.kill()
        killed.process.wait(LIMIT_S)
        apply_default_profile({}, sends_images=False)
        assert not any(it.exists() for memory in left for it in with_lock(memory))
        assert all(it.exists() for memory in kept for it in with_lock(memory))


def with_lock(memory: Path) -> tuple[Path, Path]:
    return memory, memory.with_name(f"{memory.name}_el")


@pytest.mark.parametrize("name", ["fastrtps_port7411", "fastrtps_0123456789abcdeg", "other"])
def test_other_shared_memory_stays(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fastdds, "_SHARED_MEMORY", tmp_path)
    files = with_lock(tmp_path / name)
    for file in files:
        file.touch()
    apply_default_profile({}, sends_images=False)
    assert all(it.exists() for it in files)


def test_shared_memory_of_another_user_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fastdds, "_SHARED_MEMORY", tmp_path)
    files = with_lock(tmp_path / "fastrtps_0123456789abcdef")
    for file in files:
        file.touch()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    apply_default_profile({}, sends_images=False)
    assert all(it.exists() for it in files)
    monkeypatch.undo()
    monkeypatch.setattr(fastdds, "_SHARED_MEMORY", tmp_path)
    apply_default_profile({}, sends_images=False)
    assert not any(it.exists() for it in files)


def shared_files(domain: int) -> list[Path]:
    """By which a domain's first participants get messages: memory, mutexes and, last, locks."""
    first_port = 7411 + 250 * domain  # RTPS 2.2, 9.6.1.1
    names = [f"fastrtps_port{first_port + 2 * number}" for number in range(_BLOCKED)]
    forms = ("{}", "sem.{}_mutex", "{}_el")
    return [Path("/dev/shm", form.format(name)) for form in forms for name in names]


def is_ours(file: Path) -> bool:
    return not os.path.lexists(file) or file.lstat().st_uid == os.getuid()


def remove(files: list[Path]) -> None:
    for file in files:
        file.unlink(missing_ok=True)


@pytest.fixture
def blocked_domain() -> Iterator[int]:
    """A domain in which Fast DDS cannot open shared memory, as if it belonged to another user."""
    domain = next(it for it in iter(reserve_domain, None) if all(map(is_ours, shared_files(it))))
    files = shared_files(domain)
    remove(files)  # what a participant that was killed has left
    for lock in files[-_BLOCKED:]:
        lock.symlink_to("/dev/null/nowhere/file")
    yield domain
    remove(files)


@pytest.mark.usefixtures("no_profile")
def test_errors_of_fast_dds_are_not_among_what_a_program_prints(
    blocked_domain: int,
) -> None:
    run = subprocess.run(
        [sys.executable, "-c", PARTICIPANT],
        env=environment() | {"ROS_DOMAIN_ID": str(blocked_domain)},
        input="",
        capture_output=True,
        check=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert run.stdout == "ready\n"
    assert "open_and_lock_file failed" in run.stderr
