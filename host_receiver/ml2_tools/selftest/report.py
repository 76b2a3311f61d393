"""The file of a self-test: verdicts, results and data, which may be attached to a public issue.

It has no images, no keys, addresses or serial numbers, and nothing that names the headset.
"""

import json
import re
import zipfile
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ml2_receiver.errors import ReceiverError
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.mcap_file import McapFile
from ml2_receiver.table.reader import load_table

from ..bags.bag_reader import BagReader
from ..doctor.bundle import as_json, without_secrets, write_bundle
from .evidence import Evidence
from .verdict import Verdict, as_objects

VERDICTS, RESULTS, LOG, DATA = "verdicts.json", "results.json", "log.txt", "data.mcap"
_MOST_LINES, _MOST_BYTES = 2000, 10_000_000
_HIDDEN = "<removed>"
# Images, and the name that people gave a map.
_LEFT_OUT = ("image", "confidence", "flags", "map_state")
_ADDRESSES = (
    re.compile(r"\b\d{1,3}(\.\d{1,3}){3}\b"),
    re.compile(r"\b[0-9a-fA-F]{2}(:[0-9a-fA-F]{2}){5}\b"),
    re.compile(r"\b[0-9a-fA-F]{1,4}(:[0-9a-fA-F]{0,4}){2,7}:[0-9a-fA-F]{1,4}\b|::1\b"),
    re.compile(r"\bml2s://\S+"),
)


def write_report(
    file: Path,
    verdicts: Sequence[Verdict],
    evidence: Evidence,
    data: bytes,
    names: Collection[str],
) -> None:
    """Replaces the file, all or nothing.

    Args:
        data: the numbers of a session, by numbers_of().
        names: what nobody may read in it, such as the serial number and the headset's name.

    Raises:
        ReceiverError: the file cannot be written.
    """
    texts = {
        VERDICTS: as_json(as_objects(verdicts)),
        RESULTS: as_json(_results(evidence)),
        LOG: "".join(f"{it}\n" for it in (evidence.log or ())[-_MOST_LINES:]),
    }
    anonymous_texts = {name: anonymous(text, names) for name, text in texts.items()}
    write_bundle(file, {**anonymous_texts, DATA: data})


def names_of(recording: Path) -> set[str]:
    """Returns what a recording says of whose headset it is."""
    config = BagReader(recording).config
    return {config.headset, config.device_id, config.session}


def read_verdicts(file: Path) -> list[Verdict]:
    """Returns the verdicts of a report.

    Raises:
        ReceiverError: the file is no report.
    """
    try:
        with zipfile.ZipFile(file) as report:
            if report.getinfo(VERDICTS).file_size > _MOST_BYTES:
                raise ValueError(f"{VERDICTS} is too large")
            objects = json.loads(report.read(VERDICTS))
        return [_verdict(it) for it in objects]
    except OSError as error:
        raise ReceiverError(f"cannot read {file}: {error.strerror}") from error
    except (zipfile.BadZipFile, KeyError, TypeError, ValueError, RecursionError) as error:
        raise ReceiverError(f"{file} is no report of a self-test: {error}") from error


def _verdict(fields: Mapping[str, Any]) -> Verdict:
    found = Verdict(**fields)
    texts = (found.fact, found.verdict, found.unit, found.switch)
    if not all(isinstance(it, str) for it in texts):
        raise TypeError(f"expected texts, found {texts}")
    if not isinstance(found.measured, str | float | int | None):
        raise TypeError(f"expected a number or a text, found {found.measured!r}")
    return found


def anonymous(text: str, names: Collection[str]) -> str:
    """Returns the text without keys, addresses and these names."""
    text = without_secrets(text)
    for pattern in _ADDRESSES:
        text = pattern.sub(_HIDDEN, text)
    for name in sorted(names, key=len, reverse=True):
        if name:
            text = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", _HIDDEN, text)
    return text


def _results(evidence: Evidence) -> list[Mapping[str, Any]]:
    """Returns what became of each stream in each session."""
    return [
        {
            id: {
                "values": dict(it.values),
                "reasons": it.reasons,
                "denied": it.denied,
                "messages": max(len(it.times_ns), len(it.frames)),
                "median_hz": round(it.rate_hz, 3) if it.is_delivered else None,
            }
            for id, it in session.items()
        }
        for session in evidence.sessions
    ]


def numbers_of(recording: Path) -> bytes:
    """Returns an MCAP file of the samples and poses, of metadata and lenses; without images.

    Raises:
        RecordingError: the recording cannot be read.
    """
    bag, table = BagReader(recording), load_table()
    topics: dict[str, BagTopic] = {}
    for stream in table.streams.values():
        for topic in stream.topics:
            name = topic.full_name(bag.prefix)
            if topic.role not in _LEFT_OUT and name in bag.types:
                topics[name] = BagTopic(name, bag.types[name], table.qos[topic.qos])
    with TemporaryDirectory() as folder:
        path = Path(folder) / DATA
        file = McapFile(path, "zstd", topics.values())
        for message in bag.messages():
            if message.topic in topics:
                file.write(topics[message.topic], message.time_ns, message.payload)
        file.finish(None)
        return path.read_bytes()
