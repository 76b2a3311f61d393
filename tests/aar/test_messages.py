"""Kotlin messages that `ml2-receiver messages` writes exchange bytes with ROS, by the package."""

import random
from pathlib import Path

import pytest

import own_package
from ml2_receiver import cli
from ml2_tools.messages.descriptions import types_of
from rclpy_messages import cdr, installed, some
from toolchain import Package, java, kotlinc

PACKAGES = ("arm_msgs", "std_srvs", "test_msgs")
# Reads and writes lines of `TYPE PAYLOAD`, in hexadecimal; a line of `TYPE` is for a new message.
EXCHANGE = """
import dev.ml2sensors.cdr.Cdr
import java.io.File
import kotlinx.serialization.KSerializer

class Known<T>(val serializer: KSerializer<T>, val new: () -> T) {{
    fun answer(payload: ByteArray?): ByteArray {{
        val message = if (payload == null) new() else Cdr.decodeFromByteArray(serializer, payload)
        return Cdr.encodeToByteArray(serializer, message)
    }}
}}

val known = mapOf<String, Known<*>>(
{known}
)

fun main(arguments: Array<String>) = File(arguments[0]).forEachLine {{ line ->
    val words = line.split(" ")
    val payload = words.getOrNull(1)?.chunked(2)?.map {{ it.toInt(16).toByte() }}?.toByteArray()
    val answer = try {{
        known.getValue(words[0]).answer(payload).joinToString("") {{ "%02x".format(it) }}
    }} catch (e: IllegalArgumentException) {{
        "refused: ${{e.message}}"
    }}
    println(answer)
}}
"""


@pytest.fixture(scope="module")
def exchange(
    library: Package, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[Path], Path]:
    """The compiled program, the jars that it needs, and a folder."""
    folder = tmp_path_factory.mktemp("messages")
    own_package.install(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMENT_PREFIX_PATH", str(folder))
        words = ["messages", *PACKAGES, "--language", "kotlin", "--out", str(folder / "source")]
        assert cli.main(words) == 0
        types = types_of(PACKAGES)
    classes = [(it.name, f"ros.{it.package}.{it.class_name}") for it in types]
    known = "\n".join(f'"{type}" to Known({it}.serializer()) {{ {it}() }},' for type, it in classes)
    (folder / "source/Exchange.kt").write_text(EXCHANGE.format(known=known), "utf-8")
    needed = [library.classes, *library.libraries]
    kotlinc(folder / "exchange.jar", folder / "source", class_path=needed)
    return folder / "exchange.jar", needed, folder


def answers(exchange: tuple[Path, list[Path], Path], lines: list[str]) -> list[str]:
    program, needed, folder = exchange
    (folder / "asked").write_text("\n".join(lines), "utf-8")
    return java([program, *needed], "ExchangeKt", folder / "asked").splitlines()


def test_messages_are_written_as_they_were_read(exchange: tuple[Path, list[Path], Path]) -> None:
    chance = random.Random(1)
    types = [it for it in sorted(installed()) if it.startswith(("test_msgs/", "std_srvs/"))]
    cases = [(it, cdr(some(installed()[it][0], chance))) for it in types for _ in range(10)]
    cases.append((own_package.TYPE, own_package.payloads()[1]))
    said = answers(exchange, [f"{type} {payload.hex()}" for type, payload in cases])
    assert said == [payload.hex() for _, payload in cases]


def test_new_messages_have_the_defaults_of_ros(exchange: tuple[Path, list[Path], Path]) -> None:
    types = [it for it in sorted(installed()) if it.startswith(("test_msgs/", "std_srvs/"))]
    expected = [cdr(installed()[it][0]()).hex() for it in types]
    expected.append(own_package.payloads()[0].hex())
    assert answers(exchange, [*types, own_package.TYPE]) == expected


def test_what_is_longer_than_its_bound_is_refused(
    exchange: tuple[Path, list[Path], Path],
) -> None:
    other = own_package.payloads()[1].hex()
    longer = other.replace(b"\x09\0\0\0gripper8\0\0".hex(), b"\x0a\0\0\0gripper89\0".hex())
    (said,) = answers(exchange, [f"{own_package.TYPE} {longer}"])
    assert said == "refused: tool: expected text of at most 8 bytes"
