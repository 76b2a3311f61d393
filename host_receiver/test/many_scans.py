"""A JPEG with any number of scans, made without an encoder that has such an option."""

SCAN = b"\xff\xda"


def with_scans(jpeg: bytes, count: int) -> bytes:
    """Returns the JPEG with its first scan so many times, each with four bytes of its data."""
    begin = jpeg.index(SCAN)
    head_bytes = 2 + int.from_bytes(jpeg[begin + 2 : begin + 4], "big")
    scan = jpeg[begin : begin + head_bytes + 4]
    return jpeg[:begin] + scan * count + b"\xff\xd9"
