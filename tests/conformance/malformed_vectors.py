"""Bytes that break the protocol, and what has to come of them: vectors/malformed."""

import malformed_bodies
import malformed_custom
import malformed_data
import malformed_device
import malformed_pairing
import malformed_places
import malformed_receiver

SIDES = {
    "receiver": (
        malformed_receiver,
        malformed_places,
        malformed_bodies,
        malformed_custom,
        malformed_data,
    ),
    "device": (malformed_device,),
    "pairing": (malformed_pairing,),
}


def files() -> dict[str, bytes]:
    result: dict[str, bytes] = {}
    for side, modules in SIDES.items():
        for module in modules:
            for name, case in module.cases().items():
                result |= case.files(side, name)
    return result
