"""The table of docs/waits.md has every wait and every lock of the code, and no other."""

import re
from pathlib import Path

from document import ROOT

_KOTLIN = "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors/"
_KOTLIN_WAIT = re.compile(
    r"@(?:[gs]et:)?Synchronized|synchronized\([\w@]+\)|\b\w+\??\.(?:withLock|await|join|joinAll|(?:tryA|a)cquire)\b"
    r"|\brunBlocking\b(?= *[({])|\blazy\b(?= *(?:\{|\((?!LazyThreadSafetyMode)))"
    r"|\bcall\.get\b|Thread\.sleep"
)
# Parameters with types make a definition.
_C_WAIT = re.compile(
    r"\b(?:nanosleep|await_another_thread|usleep|sleep_\w+|sem_wait|pthread_\w+|(?:xr_)?turn_take\w*|xr_take_turn)"
    r"\b(?=\((?!void|turn_t))|\block\((?!lock_t)[^)]+\)|\bFUTEX_WAIT\w*"
)
_COMMENT = ("*", "/*", "//", "import ")
_ROW = re.compile(r"^\| `([^`]+)` \| `([^`]+)` \| [^|]+ \| [^|]+ \|$", re.MULTILINE)


def in_code() -> set[tuple[str, str]]:
    kotlin = ROOT / _KOTLIN
    names = ("android", "capture", "stream", "ros", "session", "unity")
    packages = [kotlin / name for name in names]
    files = [file for package in packages for file in package.glob("*.kt")]
    files += [kotlin / "source/PlatformCalls.kt"]
    native = [ROOT / "native" / name for name in ("sdk", "sources", "openxr")]
    native_files = [file for folder in native for file in folder.glob("*.[ch]")]
    return found_in(kotlin, files, _KOTLIN_WAIT) | found_in(ROOT, native_files, _C_WAIT)


def found_in(root: Path, files: list[Path], pattern: re.Pattern[str]) -> set[tuple[str, str]]:
    return {
        (str(file.relative_to(root)), wait)
        for file in files
        for wait in waits(file.read_text(), pattern)
    }


def waits(text: str, pattern: re.Pattern[str]) -> set[str]:
    lines = [line for line in text.splitlines() if not line.strip().startswith(_COMMENT)]
    found = {it.group() for line in lines for it in pattern.finditer(line)}
    # A question mark and the accessor of a property make no other wait.
    return {re.sub(r"\?|(?<=@)[gs]et:", "", it) for it in found}


def test_each_wait_and_lock_is_in_the_table_and_none_else() -> None:
    rows = _ROW.findall((ROOT / "docs/waits.md").read_text())
    assert len(rows) == len(set(rows))
    code = in_code()
    assert len(code) > 50
    assert sorted(code - set(rows)) == [], "not in docs/waits.md"
    assert sorted(set(rows) - code) == [], "not in the code any more"
