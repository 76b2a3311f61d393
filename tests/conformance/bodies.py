"""Well-formed bodies, the starting points of all vectors."""

from typing import Any

Body = dict[str, Any]

# Texts in a malformed vector that its player replaces, at the same width, by values of the live
# session.
SESSION = "SESSION".ljust(32, "_")
TICKET = "TICKET".ljust(32, "_")
REQUEST = "REQUEST".ljust(32, "_")

HELLO: Body = {
    "versions": [1],
    "device_id": "9f86d081884c7d65",
    "instance_id": "2c26b46b68ffc68f",
    "name": "Conformance headset",
    "software": "conformance 1",
    "capabilities": {"streams": ["battery", "world_left", "tf"]},
    "permissions": {"android.permission.CAMERA": True},
}

WELCOME: Body = {
    "version": 1,
    "session": "00112233445566778899aabbccddeeff",
    "name": "Conformance receiver",
    "software": "conformance 1",
    "tickets": {
        "time": "0123456789abcdef0123456789abcdef",
        "sensors": "123456789abcdef0123456789abcdef0",
        "link_test": "3456789abcdef0123456789abcdef012",
        "world_left": "23456789abcdef0123456789abcdef01",
    },
    "received": {"battery": 12, "world_left/image_raw": 4294967297},
    "limits": {"data_bytes": 16777216},
    "timeouts": {"handshake_s": 5, "ping_s": 1, "dead_s": 2},
}

JOIN: Body = {"session": SESSION, "ticket": TICKET, "lane": "sensors"}

WORLD_CAMERA: Body = {
    "stream": 0,
    "resolution_width": 1016,
    "resolution_height": 1016,
    "update_rate": 30,
    "format": "Grayscale",
}

CONFIGURE: Body = {
    "request": 1,
    "streams": {"battery": {}, "world_left": WORLD_CAMERA, "tf": {"layout": "flat"}, "custom": {}},
}

CONFIGURED: Body = {
    "request": 1,
    "streams": {
        "battery": {"result": "applied", "values": {}},
        "world_left": {
            "result": "adjusted",
            "values": WORLD_CAMERA | {"update_rate": 20},
            "reason": "recorded at 20 Hz",
        },
        "tf": {"result": "refused", "reason": "not in this recording"},
        "custom": {"result": "applied", "values": {}},
    },
}


def channel(number: int, stream: str, role: str, topic: str, kind: str, **other: Any) -> Body:
    return {
        "id": number,
        "stream": stream,
        "role": role,
        "topic": topic,
        "type": kind,
        "qos": "sensor",
        "frame_id": "head_frame",
        "lane": "sensors",
    } | other


# The channels of the two accepted streams, on their numbers.
CHANNEL = channel(7, "battery", "battery", "battery", "sensor_msgs/msg/BatteryState")
WORLD_LEFT: Body = {"qos": "image", "frame_id": "world_left_optical_frame"}
CHANNELS = [
    CHANNEL,
    channel(
        8,
        "world_left",
        "image",
        "world_left/image_raw",
        "sensor_msgs/msg/Image",
        **WORLD_LEFT,
        lane="world_left",
    ),
    channel(
        9,
        "world_left",
        "camera_info",
        "world_left/camera_info",
        "sensor_msgs/msg/CameraInfo",
        **WORLD_LEFT,
    ),
    channel(
        10, "world_left", "metadata", "world_left/metadata", "std_msgs/msg/String", **WORLD_LEFT
    ),
]

# Named by the device.
CUSTOM = channel(
    40, "custom", "custom", "custom/room_temperature", "sensor_msgs/msg/Temperature", frame_id=""
)

STATUS: Body = {
    "final": False,
    "uptime_s": 12.5,
    "channels": {
        "battery": {"produced": 13, "sent": 12, "dropped": {"link_down": 1}},
        "world_left/image_raw": {"produced": 4294967300, "sent": 4294967300, "dropped": {}},
    },
    "clock": {
        "state": "synchronised",
        "offset_ns": -1700000000000000000,
        "uncertainty_ns": 20000,
        "round_trip_ns": 40000,
    },
}

# The optional keys of the clock in STATUS.
CLOCK_DETAILS: Body = {
    "state": "holdover",
    "skew_ppm": -12.5,
    "steps": 2,
    "epoch": 1,
    "bases": {"accel_right": "boottime", "color": "monotonic"},
}

# The optional key `streams` of STATUS.
STREAM_STATES: Body = {
    "battery": {"state": "running"},
    "world_left": {
        "state": "waiting",
        "reason": "permission android.permission.CAMERA is not granted",
        "permission": "android.permission.CAMERA",
    },
    "depth": {"state": "refused", "reason": "no such rate"},
    "gaze": {"state": "available"},
    "color": {"state": "failed", "reason": "x" * 200},
}

# The same, of streams that give way to the link.
ADAPTED_STREAMS: Body = {
    "world_left": {"state": "running", "quality": 40, "rate_hz": 1},
    "world_right": {"state": "running", "quality": 1},
    "eye_nasal_left": {"state": "running", "quality": 100},
    "depth": {"state": "running", "rate_hz": 15},
}

LINK_TEST: Body = {"bytes": 64 * 1024 * 1024}

EVENT: Body = {
    "event": "tracking_lost",
    "text": "head tracking is lost; no transforms are sent",
}

BYE: Body = {"reason": "the app was closed"}

# Of pairing: the signature is by the certificate's key over RECEIVER_FINGERPRINT, the nonce and the
# token. ECDSA is randomised, so both stand here as they were made once.
RECEIVER_FINGERPRINT = "6d" * 32
DEVICE_CERTIFICATE = (
    "MIIBPTCB5KADAgECAhR9iD4LuLxKYYTIryax2cyHfMB0AjAKBggqhkjOPQQDAjAeMRwwGgYDVQQDDBNDb25mb3Jt"
    "YW5jZSBoZWFkc2V0MCAXDTAwMDEwMTAwMDAwMFoYDzk5OTkxMjMxMjM1OTU5WjAeMRwwGgYDVQQDDBNDb25mb3Jt"
    "YW5jZSBoZWFkc2V0MFkwEwYHKoZIzj0CAQYIKoZIzj0DAQcDQgAEa/hdX+hFmLEMphmewJzNfTXc1xlf3R3Hc3oM"
    "ZwBu8lG5UvJe7B3u0fyhkYOJkEZjV9MUrft+l2C42a/I85qVrTAKBggqhkjOPQQDAgNIADBFAiB7rKBORPjzNKm7"
    "LQ8W4+iVXREZZsmxh7Nnl67ImYeIUQIhAL7DUYnlHl3iz3raiLJFNti92XIvwU5wVHtCAi2Pp68z"
)
PAIR_SIGNATURE = (
    "MEQCIAsaSvkn/QxB9FY2epHsxwj/H7U3RlNKGEm7+inrtph+AiBcnQwwOYg+o0eJFUZtHbzzPU7/hberCyUIj7nT"
    "uFVLFQ=="
)

PAIR_CHALLENGE: Body = {
    "nonce": "00112233445566778899aabbccddeeff" * 2,
    "name": "Conformance receiver",
    "software": "conformance 1",
}

PAIR: Body = {
    "token": "0f1e2d3c4b5a69788796a5b4c3d2e1f0",
    "name": "Größe 眼鏡",
    "device_id": "9f86d081884c7d65",
    "certificate": DEVICE_CERTIFICATE,
    "signature": PAIR_SIGNATURE,
}

PAIRED: Body = {"name": "Conformance receiver", "port": 7755}


# std_msgs/String "hi": encapsulation, length with the final zero, text, zero.
_STRING = "00010000 03000000 686900"
STRING_PAYLOAD = bytes.fromhex(_STRING)

CONFIGURED_LIVE: Body = CONFIGURED | {"request": REQUEST}

# The bodies that malformed cases change, by kind and variant: JSON, or pieces of bytes.
VALID: dict[str, Any] = {
    "HELLO": HELLO,
    "WELCOME": WELCOME,
    "JOIN": JOIN,
    "JOINED": {"lane": "sensors"},
    "CONFIGURE": CONFIGURE,
    "CONFIGURED": CONFIGURED_LIVE,
    "CHANNEL": CHANNEL,
    "CHANNEL image": CHANNELS[1],
    "CHANNEL custom": CUSTOM,
    "CHANNEL_END": {"id": CHANNEL["id"]},
    "START": {"request": 1},
    "DATA": [{"hex": _STRING}],
    "TIME_REQUEST": [{"hex": "00", "times": 8}],
    "TIME_REPLY": [{"hex": "00", "times": 24}],
    "LINK_TEST": LINK_TEST,
    "FILLER": ["noise"],
    "STATUS": STATUS,
    "EVENT": EVENT,
    "ERROR": {"code": "busy", "message": "no", "fatal": True},
    "BYE": BYE,
    "PAIR": PAIR,
    "PAIRED": {"name": "x", "port": 1},
}
