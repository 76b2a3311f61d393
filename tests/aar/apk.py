"""The app of `make apk`: its files, and what Android's tools read in it."""

import re
import struct
import zipfile
from dataclasses import dataclass
from pathlib import Path

from toolchain import ROOT, maven_property, run

APK = ROOT / "build" / "apk" / f"ml2-sensors-{maven_property('revision')}.apk"
# Before an entry's name and extra field, whose lengths are the last four of these bytes.
_LOCAL_HEADER_BYTES = 30


@dataclass(frozen=True)
class Entry:
    """A file of the package; its bytes begin at `offset`."""

    is_stored: bool
    offset: int
    packed_bytes: int


def entries() -> dict[str, Entry]:
    found = {}
    with zipfile.ZipFile(APK) as archive, APK.open("rb") as file:
        for info in archive.infolist():
            file.seek(info.header_offset)
            lengths = file.read(_LOCAL_HEADER_BYTES)[-4:]
            offset = info.header_offset + _LOCAL_HEADER_BYTES + sum(struct.unpack("<HH", lengths))
            is_stored = info.compress_type == zipfile.ZIP_STORED
            found[info.filename] = Entry(is_stored, offset, info.compress_size)
    return found


def permissions(application: Path) -> set[str]:
    """Returns the permissions that an application, or a manifest in text form, asks for."""
    if application.suffix == ".xml":
        return set(re.findall(r'uses-permission android:name="(.*?)"', application.read_text()))
    printed = run("aapt", "dump", "permissions", application)
    return set(re.findall(r"^uses-permission: name='(.*)'$", printed, re.MULTILINE))
