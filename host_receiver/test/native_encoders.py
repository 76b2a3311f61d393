"""The encoders of libml2sensors.so as it ships, called as C.

Output has the size of ml2s_most_encoded_bytes and bytes after it that must stay as they were.
"""

import ctypes
import functools
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
GREY_JPEG, DEPTH_RVL = 1, 2
_GUARD = b"\xa5" * 64


class EncoderError(Exception):
    """The library refused an image; its message says why."""


class _Error(ctypes.Structure):
    _fields_ = (
        ("struct_size", ctypes.c_uint32),
        ("vendor_code", ctypes.c_int32),
        ("message", ctypes.c_char * 248),
    )


class _Image(ctypes.Structure):
    _fields_ = (
        ("struct_size", ctypes.c_uint32),
        ("codec", ctypes.c_uint32),
        ("quality", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("stride_bytes", ctypes.c_uint32),
        ("data", ctypes.c_void_p),
        ("size_bytes", ctypes.c_uint64),
    )


class _Memory(ctypes.Structure):
    _fields_ = (("data", ctypes.c_void_p), ("size_bytes", ctypes.c_uint64))


@functools.cache
def _library() -> ctypes.CDLL:
    """Loads the library after those of Android's names that it needs."""
    for name in ("libc", "libm", "libdl", "liblog"):
        ctypes.CDLL(str(ROOT / f"build/native/linux/{name}.so"), ctypes.RTLD_GLOBAL)
    return ctypes.CDLL(str(ROOT / "build/native/device/libml2sensors.so"))


def encode(codec: int, pixels: NDArray[Any], quality: int = 0) -> bytes:
    """Encodes a two-dimensional array, whose rows may be apart.

    Raises:
        EncoderError: the library refuses the image.
    """
    height, width = pixels.shape
    rows, columns = pixels.strides
    assert columns == pixels.itemsize
    size = (height - 1) * rows + width * columns
    data = pixels.ctypes.data
    image = _Image(ctypes.sizeof(_Image), codec, quality, width, height, rows, data, size)
    error = _Error(ctypes.sizeof(_Error))
    length = ctypes.c_uint64()

    def call(name: str, *arguments: Any) -> int:
        status: int = getattr(_library(), name)(
            ctypes.byref(image), *arguments, ctypes.byref(length), ctypes.byref(error)
        )
        if status != 0:
            raise EncoderError(error.message.decode())
        return int(length.value)

    most = call("ml2s_most_encoded_bytes")
    output = ctypes.create_string_buffer(most + len(_GUARD))
    ctypes.memmove(ctypes.addressof(output) + most, _GUARD, len(_GUARD))
    written = call("ml2s_encode", _Memory(ctypes.addressof(output), most))
    assert written <= most
    assert output.raw[most:] == _GUARD
    return output.raw[:written]
