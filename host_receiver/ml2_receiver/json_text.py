"""JSON that every reader takes: without NaN and infinities."""

import json
import math
from typing import Any


def json_text(value: Any, *, indent: int | None = None, is_ascii: bool = True) -> str:
    """Returns a value as JSON; null stands for numbers that JSON does not have.

    Args:
        is_ascii: other characters are escaped.
    """
    try:
        return json.dumps(value, indent=indent, ensure_ascii=is_ascii, allow_nan=False)
    except ValueError:
        known = _finite(value)
        return json.dumps(known, indent=indent, ensure_ascii=is_ascii, allow_nan=False)


def _finite(value: Any) -> Any:
    match value:
        case float():
            return value if math.isfinite(value) else None
        case dict():
            return {key: _finite(it) for key, it in value.items()}
        case list() | tuple():
            return [_finite(it) for it in value]
    return value
