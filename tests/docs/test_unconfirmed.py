"""docs/unconfirmed.md: what it says to live somewhere does."""

from __future__ import annotations

import re

from document import ROOT, files

ROWS = [
    [cell.strip() for cell in row.split(" | ")]
    for row in (ROOT / "docs" / "unconfirmed.md").read_text().split("## Programs")[0].splitlines()
    if row.startswith("| ") and not row.startswith("| fact")
]


def test_every_fact_says_where_it_lives_and_how_to_check_it() -> None:
    assert len(ROWS) > 20
    for row in ROWS:
        assert len(row) == 4, row
        assert re.search(r"`[\w/.]+:[^`]+`", row[2]), row
        assert len(row[3]) > 5, row


def test_every_place_exists() -> None:
    known = {f"/{it.relative_to(ROOT)}": it for it in files()}
    missing = []
    for name, words in re.findall(r"`([\w/.]+):([^`]+)`", " ".join(row[2] for row in ROWS)):
        found = [it for it in known if it.endswith(f"/{name}")]
        if len(found) != 1 or words not in known[found[0]].read_text():
            missing.append(f"{name}:{words}, found {found}")
    assert not missing, "\n".join(missing)
