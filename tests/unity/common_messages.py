"""Messages of the types that scripts publish, with the bytes that rosbags writes for them.

Usage: common_messages.py FILE. Two cases of each type, one with empty sequences and texts, as
tests/conformance/cdr_vectors.py describes its files.
"""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "config"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host_receiver"))
from csharp_messages import COMMON

STORE = get_typestore(Stores.ROS2_JAZZY)


class Filler:
    """Random values of ROS types by name, as rosbags and as JSON have them."""

    def __init__(self, seed: int, sequence_length: int) -> None:
        self._random, self._length = random.Random(seed), sequence_length

    def message(self, type: str) -> tuple[Any, dict[str, Any]]:
        fields = {name: self._field(kind) for name, kind in STORE.fielddefs[type][1]}
        message = STORE.types[type](**{name: value for name, (value, _) in fields.items()})
        return message, {name: shown for name, (_, shown) in fields.items()}

    def _field(self, kind: Any) -> tuple[Any, Any]:
        match kind:
            case (Nodetype.BASE, (name, _)):
                return self._base(name)
            case (Nodetype.NAME, name):
                return self.message(name)
            case (node, (element, length)):
                count = length if node == Nodetype.ARRAY else self._length
                return self._several(element, [self._field(element) for _ in range(count)])
        raise AssertionError(kind)

    def _several(self, element: Any, items: list[tuple[Any, Any]]) -> tuple[Any, Any]:
        values, shown = [value for value, _ in items], [it for _, it in items]
        is_number = element[0] == Nodetype.BASE and element[1][0] != "string"
        return (np.array(values, element[1][0]) if is_number else values), shown

    def _base(self, name: str) -> tuple[Any, Any]:
        if name == "string":
            text = "".join(self._random.choices("aß€😀", k=self._length))
            return text, text
        if name == "bool":
            flag = self._random.random() < 0.5
            return flag, flag
        if name.startswith("float"):
            number = float(np.dtype(name).type(self._random.uniform(-1e6, 1e6)))
            return number, number
        limits = np.iinfo(np.dtype(name))
        whole = self._random.randint(int(limits.min), int(limits.max))
        return whole, whole


def main(file: Path) -> None:
    cases = {}
    for name in COMMON.split():
        type = name.replace("/", "/msg/")
        for seed, sequence_length in enumerate((0, 3)):
            message, shown = Filler(seed, sequence_length).message(type)
            payload = bytes(STORE.serialize_cdr(message, type)).hex()
            case = {"type": type, "message": shown, "bytes": [{"hex": payload}]}
            cases[f"{type.rpartition('/')[2]}{sequence_length}"] = case
    file.write_text(json.dumps(cases))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
