"""Generated C# messages of every installed type exchange bytes with rclpy, in mono."""

import random
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rclpy.task import Future

import own_package
from ml2_receiver import cli
from ml2_receiver.ros.context import end_node
from rclpy_messages import ENCAPSULATION, cdr, installed, some
from ros_domain import reserve_domain

ROOT = Path(__file__).parents[2]
MESSAGES = ROOT / "unity_package/Runtime/Messages"
LIMIT_S = 120
TEST_MSGS = sorted(it for it in installed() if it.startswith("test_msgs/msg/"))
chances = st.integers(0, 1 << 64).map(random.Random)
# A busy machine draws data slowly, which proves nothing about the code under test.
patient = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


class Mono:
    """A C# program with a class of each type."""

    def __init__(self, program: Path) -> None:
        self._process = subprocess.Popen(
            ["mono", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> "Mono":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate(timeout=LIMIT_S)

    def answer(self, type: str, payload: bytes | None = None) -> str:
        """Returns what was written, and the bytes that a second read allocated; or an error.

        Without a payload, returns what a new message writes.
        """
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(f"{type}\n" if payload is None else f"{type} {payload.hex()}\n")
        process.stdin.flush()
        answer = process.stdout.readline().strip()
        assert answer, f"the program ended at {type} {payload!r}"
        return answer

    def written(self, type: str, payload: bytes) -> bytes:
        answer = self.answer(type, payload)
        payload_hex, _, allocated = answer.partition(" ")
        assert allocated == "0", f"{type}: {answer}"
        return bytes.fromhex(payload_hex)


@pytest.fixture(scope="module")
def mono(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mono]:
    """A program with the classes of all installed packages, and of a package of a user."""
    prefix, out = (tmp_path_factory.mktemp(it) for it in ("arm", "csharp"))
    own_package.install(prefix)
    packages = sorted({it.partition("/")[0] for it in installed()})
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMENT_PREFIX_PATH", str(prefix))
        assert written(out, *packages, "arm_msgs") == 0
    sources = [*MESSAGES.rglob("*.cs"), *out.glob("*.cs"), Path(__file__).parent / "Exchange.cs"]
    options = ["-langversion:7.2", "-unsafe", "-warnaserror+", "-warn:4", "-nologo"]
    program = out / "Exchange.exe"
    subprocess.run(["mcs", *options, f"-out:{program}", *sources], check=True)
    with Mono(program) as running:
        yield running


def written(out: Path, *packages: str, language: str = "csharp") -> int:
    """Runs the command; returns its exit code."""
    return cli.main(["messages", *packages, "--language", language, "--out", str(out)])


@pytest.mark.parametrize("type", sorted(installed()))
@given(chance=chances)
@settings(patient, max_examples=10)
def test_a_message_of_rclpy_is_written_as_it_was_read(
    mono: Mono, type: str, chance: random.Random
) -> None:
    """Also with random bytes in padding and tail. A second read allocates nothing."""
    message = some(installed()[type][0], chance)
    expected = cdr(message)
    dirty = cdr(message, chance) + chance.randbytes(chance.randrange(9))
    for payload in (expected, serialize_message(message), dirty):
        assert mono.written(type, payload) == expected


@pytest.mark.parametrize("type", sorted(installed()))
def test_a_new_message_has_the_defaults_of_ros(mono: Mono, type: str) -> None:
    assert bytes.fromhex(mono.answer(type)) == cdr(installed()[type][0]())


def test_a_package_of_a_user_has_its_messages(mono: Mono) -> None:
    default, other = own_package.payloads()
    assert bytes.fromhex(mono.answer(own_package.TYPE)) == default
    assert mono.written(own_package.TYPE, other) == other


def test_constants_have_their_values(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_package.install(tmp_path)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    for language, file, const in (
        ("csharp", "ArmMsgs.cs", "const byte CLOSED = 1;"),
        ("csharp", "ArmMsgs.cs", 'const string GREETING = "the robot\'s \\"hand\\"";'),
        ("kotlin", "arm_msgs.kt", "const val CLOSED: UByte = 1u\n"),
        ("kotlin", "arm_msgs.kt", 'const val GREETING: String = "the robot\'s \\"hand\\""\n'),
    ):
        assert written(tmp_path / language, "arm_msgs", language=language) == 0
        assert const in (tmp_path / language / file).read_text("utf-8")


def test_files_are_written_again_but_never_those_of_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert [written(tmp_path, "std_srvs"), written(tmp_path, "std_srvs")] == [0, 0]
    (tmp_path / "StdSrvs.cs").write_text("mine")
    assert written(tmp_path, "std_srvs") == 2
    assert "StdSrvs.cs: expected a file of this command" in capsys.readouterr().err
    assert (tmp_path / "StdSrvs.cs").read_text() == "mine"


def test_a_package_that_is_not_there_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert written(tmp_path, "no_msgs") == 2
    assert "expected a package no_msgs with descriptions of messages" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


class Echo:
    """A publisher and a raw subscription of each type, in a domain of their own."""

    def __init__(self) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=reserve_domain())
        self._node = Node("exchange", context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._future: Future = Future()
        self._publishers: dict[str, Any] = {}
        for type in TEST_MSGS:
            message, topic = installed()[type][0], type.rpartition("/")[2].lower()
            qos = QoSProfile(depth=10)
            self._node.create_subscription(message, topic, self._take, qos, raw=True)
            self._publishers[type] = self._node.create_publisher(message, topic, qos)

    def __enter__(self) -> "Echo":
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        end_node(self._node)

    def _take(self, payload: bytes) -> None:
        self._future.set_result(payload)

    def passed_on(self, type: str, message: Any) -> bytes:
        """Returns the bytes of a message, or the bytes given, as a subscription takes them."""
        self._future = Future()
        self._publishers[type].publish(message)
        self._executor.spin_until_future_complete(self._future, timeout_sec=LIMIT_S)
        assert self._future.done(), f"{type} did not come back"
        payload: bytes = self._future.result()
        return payload


@pytest.fixture(scope="module")
def echo() -> Iterator[Echo]:
    with Echo() as passing:
        yield passing


@pytest.mark.parametrize("type", TEST_MSGS)
@given(chance=chances)
@settings(patient, max_examples=10)
def test_messages_pass_between_csharp_and_ros(
    mono: Mono, echo: Echo, type: str, chance: random.Random
) -> None:
    message = some(installed()[type][0], chance)
    sent = mono.written(type, echo.passed_on(type, message))
    assert sent == cdr(message)
    assert mono.written(type, echo.passed_on(type, sent)) == sent


@pytest.mark.parametrize("type", TEST_MSGS)
@given(chance=chances)
@settings(patient, max_examples=20)
def test_malformed_bytes_are_answered_with_field_and_offset(
    mono: Mono, type: str, chance: random.Random
) -> None:
    payload = cdr(some(installed()[type][0], chance))
    for wrong in (payload[: chance.randrange(len(payload))], altered(payload, chance)):
        answer = mono.answer(type, wrong)
        if answer.startswith("malformed"):
            offset = int(answer.split()[1])
            assert 0 <= offset <= len(wrong)
            assert f"at byte {offset}: expected" in answer
        else:
            assert len(bytes.fromhex(answer.split()[0])) <= 2 * len(wrong) + 8


def altered(payload: bytes, chance: random.Random) -> bytes:
    """Returns the payload with some bytes replaced, as lengths above all."""
    wrong = bytearray(payload)
    for _ in range(chance.randrange(1, 4)):
        at = 4 * chance.randrange(len(wrong) // 4)
        wrong[at : at + 4] = chance.choice(
            [b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", bytes(4), chance.randbytes(4)]
        )
    return bytes(wrong[: len(payload)])


def texts(*values: bytes) -> bytes:
    return b"".join(struct.pack("<I", len(it)) + it for it in values)


@pytest.mark.parametrize(
    ("type", "body", "error"),
    [
        ("std_msgs/msg/Bool", b"\2", "data at byte 4: expected bool of 0 or 1, found 2"),
        ("std_msgs/msg/Float64", bytes(7), "data at byte 4: expected 8 bytes, found 7"),
        ("std_msgs/msg/String", texts(b""), "data at byte 4: expected a text with the NUL"),
        ("std_msgs/msg/String", texts(b"ab"), "data at byte 9: expected NUL, found 0x62"),
        ("std_msgs/msg/String", texts(b"a\0\0"), "data at byte 9: expected UTF-8 without NUL"),
        ("std_msgs/msg/String", texts(b"a\xc3\0"), "data at byte 9: expected UTF-8"),
        ("std_msgs/msg/String", texts(b"\xc0\x80\0"), "data at byte 8: expected UTF-8"),
        ("std_msgs/msg/String", texts(b"\xed\xa0\x80\0"), "data at byte 8: expected UTF-8"),
        ("std_msgs/msg/String", texts(b"\xf4\x90\x80\x80\0"), "data at byte 8: expected UTF-8"),
        ("std_msgs/msg/String", b"\xff\xff\xff\xffab\0", "data at byte 4: expected a length"),
        ("test_msgs/msg/WStrings", struct.pack("<II", 1, 1 << 16), "wstring_value at byte 8: exp"),
        ("test_msgs/msg/WStrings", struct.pack("<III", 2, 65, 0xD800), "wstring_value at byte 12:"),
        (
            "test_msgs/msg/BoundedSequences",
            struct.pack("<I", 4) + bytes(400),
            "bool_values at byte 4: expected a length of at most 3, found 4",
        ),
        (
            "test_msgs/msg/UnboundedSequences",
            struct.pack("<I", 2) + b"\1\3" + bytes(400),
            "bool_values at byte 9: expected bools of 0 or 1, found 3",
        ),
        (
            "test_msgs/msg/Strings",
            6 * (texts(b"\0") + bytes(3)) + struct.pack("<I", 24) + bytes(99),
            "bounded_string_value at byte 52: expected a length of at most 23, found 24",
        ),
        (
            "nav_msgs/msg/Path",
            struct.pack("<iI", 0, 0) + texts(b"map\0") + struct.pack("<I", 1 << 30) + bytes(99),
            "poses at byte 20: expected a length of at most 1 in 99 bytes, found 1073741824",
        ),
        (
            "nav_msgs/msg/Path",
            struct.pack("<iI", 0, 0) + texts(b"map\0") + struct.pack("<I", 1) + bytes(8)
            + texts(b"map") + bytes(99),
            "poses[0].header.frame_id at byte 38: expected NUL, found 0x70",
        ),
        ("sensor_msgs/msg/JointState", struct.pack("<iI", 0, 0) + texts(b"\0") + bytes(3)
         + struct.pack("<I", 2) + texts(b"a\0") + bytes(2) + texts(b"bc") + bytes(20),
         "name[1] at byte 37: expected NUL, found 0x63"),
    ],
)  # fmt: skip
def test_each_kind_of_malformed_bytes_names_its_field(
    mono: Mono, type: str, body: bytes, error: str
) -> None:
    answer = mono.answer(type, ENCAPSULATION + body)
    assert answer.startswith("malformed ")
    assert error in answer


@pytest.mark.parametrize("head", ["00", "00 00 00 00", "00 03 00 00", "01 01 00 00"])
def test_another_encapsulation_is_refused(mono: Mono, head: str) -> None:
    answer = mono.answer("std_msgs/msg/Int64", bytes.fromhex(head) + bytes(8))
    assert "message at byte 0: expected encapsulation 00 01" in answer
