"""A document that says what `ros2` does also says what does it without that command."""

from __future__ import annotations

import re

from document import ROOT, files

COUNTERPARTS = {
    "topic list": "topics",
    "topic hz": "topics",
    "topic echo": "echo",
    "param set": "set",
    "param describe": "config show",
    "service call": "call",
    "bag record": "record",
    "bag play": "play",
}
# Programs of other packages, which come with a ROS that has the command.
OTHERS = {"launch", "run", "pkg", "interface", "bag reindex", "bag convert", "bag"}


def test_what_works_here_stands_beside_each_use_of_ros2() -> None:
    missing = []
    for document in files("*.md"):
        text = document.read_text()
        for verb in set(re.findall(r"\bros2 ((?:topic|param|service|bag) [a-z]+|[a-z]+)", text)):
            if verb in OTHERS:
                continue
            counterpart = COUNTERPARTS[verb]
            if not re.search(rf"(?:ml2-receiver |`){counterpart}\b", text):
                missing.append(f"{document.relative_to(ROOT)}: ros2 {verb}: {counterpart}")
    assert not missing, "\n".join(missing)
