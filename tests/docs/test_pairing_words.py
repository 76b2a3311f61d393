"""Users are told ways to pair that exist."""

import re

from document import ROOT, files

USERS_READ = ("*.md", "host_receiver/ml2_receiver/*.py", "ml2-sensors-aar/*/src/main/*", "*.kt")


def test_nobody_is_told_to_scan_a_code_that_nothing_scans() -> None:
    """Neither the app nor the library has a reader of QR codes."""
    told = [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()}"
        for file in files(*USERS_READ)
        if "/src/test/" not in str(file) and file.suffix in (".md", ".py", ".kt", ".xml")
        for number, line in enumerate(file.read_text().splitlines(), 1)
        if re.search(r"\bscan(?!_)", line, re.IGNORECASE)
    ]
    assert not told, "\n".join(told)
