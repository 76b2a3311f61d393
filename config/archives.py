"""Archives whose bytes depend on nothing but names and contents of their files."""

import gzip
import io
import subprocess
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

# The date of every file in an archive, as in pom.xml: the first that a zip can express.
DATE_S = 315532802
_ZIP_DATE = (1980, 1, 1, 0, 0, 2)


def source_files(folder: Path) -> dict[str, bytes]:
    """The files of a folder that git has or would add, by their names relative to it, sorted."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout
    names = sorted(set(filter(None, listed.split("\0"))))
    return {name: (folder / name).read_bytes() for name in names if (folder / name).is_file()}


def tar_gz(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with (
        gzip.GzipFile(fileobj=packed, mode="wb", filename="", mtime=0) as zipped,
        tarfile.open(fileobj=zipped, mode="w", format=tarfile.PAX_FORMAT) as archive,
    ):
        for name, content in sorted(files.items()):
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            entry.mtime = DATE_S
            entry.mode = 0o644
            archive.addfile(entry, io.BytesIO(content))
    return packed.getvalue()


def untar(packed: bytes) -> dict[str, bytes]:
    """The files of a tar archive by name."""
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        read = ((entry.name, archive.extractfile(entry)) for entry in archive)
        return {name: file.read() for name, file in read if file is not None}


def stored_zip(files: Mapping[str, bytes]) -> bytes:
    """A zip without compression, for files that are compressed already."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in sorted(files.items()):
            entry = zipfile.ZipInfo(name, _ZIP_DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return packed.getvalue()
