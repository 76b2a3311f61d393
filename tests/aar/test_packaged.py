"""The headset with the classes of the Android package instead of those that Maven built."""

import os
import re
import zipfile
from pathlib import Path

from counters import have_arrived
from processes import HEADSET, ROOT, receive
from simulation import raw_config

NATIVE = ROOT / "build" / "native"
TARGET = HEADSET.parent / "target"


def test_every_sensor_arrives_with_the_classes_of_the_package(tmp_path: Path) -> None:
    (package,) = (ROOT / "build" / "aar").glob("ml2-sensors-[0-9]*[0-9].aar")
    with zipfile.ZipFile(package) as archive:
        classes = Path(archive.extract("classes.jar", tmp_path))
    config = tmp_path / "everything.yaml"
    config.write_text(raw_config())
    received = receive(
        config,
        [],
        tmp_path,
        program=program(classes),
        is_enough=have_arrived({}, of_others=1),
    )
    assert {answer["result"] for answer in received.snapshot["streams"].values()} == {"applied"}
    assert [name for name, (_, payloads) in received.topics.items() if not payloads] == []
    log = (tmp_path / "headset.log").read_text()
    assert "ended: SIGTERM" in log
    faults = re.search("WARNING: (?!--insecure)|FATAL ERROR", log)
    assert not faults, "the JVM checks every JNI call"


def program(classes: Path) -> list[str | Path]:
    """Returns the command of the script ml2-headset, with `classes` instead of Maven's jar."""
    (headset,) = TARGET.glob("ml2-headset-*.jar")
    others = [it for it in (TARGET / "lib").iterdir() if not it.name.startswith("ml2-sensors-")]
    assert len(others) < len(list((TARGET / "lib").iterdir()))
    return [
        *("java", "-Xcheck:jni", "-XX:TieredStopAtLevel=1"),
        *("-Xmx1g", "-XX:MaxDirectMemorySize=512m"),
        f"-Dml2s.frame_cache={NATIVE / 'frame_cache'}",
        *("-cp", os.pathsep.join(str(it) for it in (classes, headset, *others))),
        "dev.ml2sensors.simulator.MainKt",
    ]
