"""The tables of docs/unconfirmed.md, from config/facts.yaml."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from ml2_receiver.errors import TableError
from ml2_receiver.table.stream_table import StreamTable

_STAGES = {"unattended", "attended", "long", "by_hand"}


def facts_table(file: Path, table: StreamTable, claim: str) -> Iterator[str]:
    """Yields the lines of the table of the facts that have this claim, `assumed` or `stated`.

    Raises:
        TableError: a fact has an unknown stage or key of the configuration.
    """
    facts: dict[str, dict[str, Any]] = yaml.safe_load(file.read_text("utf-8"))
    yield f"| fact | {claim} | lives in | how to check it | self-test | key to try if it differs |"
    yield "|---|---|---|---|---|---|"
    for name, fact in facts.items():
        keys = fact.get("keys", [])
        if fact["stage"] not in _STAGES:
            raise TableError(f"facts.yaml, {name}: {fact['stage']} is none of {sorted(_STAGES)}")
        known = {f"{section}.{key}" for section, it in table.sections.items() for key in it.keys}
        if unknown := [it for it in keys if it not in known]:
            raise TableError(f"facts.yaml, {name}: the configuration has no {unknown[0]}")
        if claim in fact:
            places = "<br>".join(f"`{it}`" for it in fact["code"])
            named = ", ".join(f"`{it}`" for it in keys)
            unjudged = fact.get("unjudged")
            judged = f"no: {unjudged}" if unjudged else f"`{name}`"
            cells = fact["fact"], fact[claim], places, fact["check"], judged, named
            yield f"| {' | '.join(cells)} |"
