"""The definitions of message types for recordings; config/generate.py writes them."""

import json
from collections.abc import Mapping
from importlib import resources

_FILE = resources.files("ml2_receiver") / "data" / "message_definitions.json"

# By type: .msg text with all types it uses, as the schema encoding `ros2msg` of MCAP has it.
DEFINITIONS: Mapping[str, str] = {
    type: "\n".join(lines) + "\n" for type, lines in json.loads(_FILE.read_text("utf-8")).items()
}
