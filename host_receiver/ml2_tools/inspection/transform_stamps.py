"""Checks that no transform is published twice with the same stamp."""

from collections.abc import Iterator

import numpy as np

from .check import Check
from .survey import Survey


def transform_stamps(survey: Survey) -> Iterator[Check]:
    """Checks each transform on /tf; stamps may come in any order."""
    for (parent, child), stamps in survey.transforms.items():
        stamps_ns = np.array(stamps, np.int64)
        repeated = len(stamps_ns) - len(np.unique(stamps_ns))
        figures = {"transforms": len(stamps_ns), "repeated": repeated}
        found = f"{len(stamps_ns)} transforms"
        if repeated:
            found += f", {repeated} with a stamp that was published before"
        name = f"{parent} -> {child}"
        yield Check(name, "stamps", "hint" if repeated else "ok", found, figures)
