"""The well-formed bodies from which cases begin: vectors/valid/bodies.json."""

import json
from pathlib import Path
from typing import Any

from pieces import joined

VECTORS = Path(__file__).parent / "vectors"

# By kind and variant: an object is JSON, a list is pieces of bytes.
VALID: dict[str, Any] = json.loads((VECTORS / "valid" / "bodies.json").read_text("utf-8"))

# Texts in a malformed case that its player replaces, at the same width, by values of the live
# session.
SESSION = "SESSION".ljust(32, "_")
TICKET = "TICKET".ljust(32, "_")
REQUEST = "REQUEST".ljust(32, "_")

HELLO, CONFIGURE, CONFIGURED = (VALID[it] for it in ("HELLO", "CONFIGURE", "CONFIGURED"))
# The channels of the two streams that the device accepts.
CHANNELS = [
    VALID[it] for it in ("CHANNEL", "CHANNEL image", "CHANNEL camera_info", "CHANNEL metadata")
]
# The openings of an app in the state `opened`; the receiver refuses the last one.
_USES = ("", " bulk", " client", " service", " transform", " refused")
OPENINGS = [VALID[f"OPEN{it}"] for it in _USES]
STRING_PAYLOAD = joined(VALID["DATA"])
