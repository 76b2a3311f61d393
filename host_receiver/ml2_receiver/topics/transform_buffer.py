"""Keeps the transforms of /tf and /tf_static, and gives the pose of one frame in another."""

from __future__ import annotations

import math
import struct
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

_KEPT_NS = 10_000_000_000
_MOST_KEPT = 1000
_MOST_FRAMES = 10_000
_TIME = struct.Struct("<iI")
_LENGTH = struct.Struct("<I")
_NUMBERS = struct.Struct("<7d")
_HEAD_BYTES = 4  # of the encapsulation

type Vector = tuple[float, float, float]
type Quaternion = tuple[float, float, float, float]


class Rigid(NamedTuple):
    """A translation in m, and a unit quaternion (x, y, z, w) that rotates before it."""

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def after(self, first: Rigid) -> Rigid:
        """Returns `first`, and then this one."""
        x, y, z = rotated(self.rotation, first.translation)
        a, b, c = self.translation
        return Rigid((x + a, y + b, z + c), product(self.rotation, first.rotation))

    def inverse(self) -> Rigid:
        x, y, z, w = self.rotation
        back = (-x, -y, -z, w)
        a, b, c = rotated(back, self.translation)
        return Rigid((-a, -b, -c), back)


class StampedPose(NamedTuple):
    """The pose of a frame in another at a ROS time in ns; 0 if no transform between them moves.

    `newest_ns` is the stamp of the oldest among the newest of the moving transforms.
    """

    pose: Rigid
    stamp_ns: int
    newest_ns: int


class TransformError(LookupError):
    """There is no pose; the message says which transform is missing."""


@dataclass
class _Edge:
    """The transforms of a frame to its parent, oldest first."""

    parent: str
    is_static: bool
    stamps: list[int] = field(default_factory=list)
    transforms: list[Rigid] = field(default_factory=list)

    def put(self, stamp_ns: int, transform: Rigid) -> None:
        if self.is_static:
            self.stamps, self.transforms = [stamp_ns], [transform]
            return
        at = len(self.stamps)
        if self.stamps and stamp_ns <= self.stamps[-1]:
            at = bisect_left(self.stamps, stamp_ns)
            if self.stamps[at] == stamp_ns:
                self.transforms[at] = transform
                return
        self.stamps.insert(at, stamp_ns)
        self.transforms.insert(at, transform)
        # Both now and then, since each costs as much as all that is kept
        if len(self.stamps) > 2 * _MOST_KEPT or self.stamps[0] < self.stamps[-1] - 2 * _KEPT_NS:
            first = bisect_left(self.stamps, self.stamps[-1] - _KEPT_NS)
            first = max(first, len(self.stamps) - _MOST_KEPT)
            del self.stamps[:first], self.transforms[:first]

    def at(self, stamp_ns: int) -> Rigid:
        """Returns the transform of a time between the oldest and the newest, or the nearest one."""
        at = bisect_left(self.stamps, stamp_ns)
        if at == len(self.stamps):
            return self.transforms[-1]
        if at == 0 or self.stamps[at] == stamp_ns:
            return self.transforms[at]
        begin, end = self.stamps[at - 1], self.stamps[at]
        share = (stamp_ns - begin) / (end - begin)
        return between(self.transforms[at - 1], self.transforms[at], share)


class TransformBuffer:
    """One tree of frames, with the transforms of the last 10 s. Not thread-safe.

    It keeps 1000 transforms of a frame at least, and 10,000 frames at most.

    Attributes:
        refused: transforms that are no rotation, make a frame its own parent, or are of one frame
            too many.
    """

    def __init__(self) -> None:
        self.refused = 0
        self._edges: dict[str, _Edge] = {}

    def add_message(self, payload: bytes, *, is_static: bool) -> None:
        """Takes a TFMessage as plain CDR.

        Raises:
            ValueError: it ends too early.
        """
        for parent, child, stamp_ns, transform in _transforms(payload):
            self.add(parent, child, stamp_ns, transform, is_static=is_static)

    def add(
        self, parent: str, child: str, stamp_ns: int, transform: Rigid, *, is_static: bool
    ) -> None:
        """Takes the pose of `child` in `parent`; a rotation of another length is made a unit."""
        unit = _unit(transform)
        edge = self._edges.get(child)
        is_full = edge is None and len(self._edges) >= _MOST_FRAMES
        if unit is None or is_full or child == parent or not child:
            self.refused += 1
            return
        if edge is None or edge.parent != parent or edge.is_static != is_static:
            edge = self._edges[child] = _Edge(parent, is_static)
        edge.put(stamp_ns, unit)

    def look_up(self, frame: str, reference: str) -> StampedPose:
        """Returns the pose of `frame` in `reference`, at the newest time that all transforms have.

        Raises:
            TransformError: they are not in one tree.
        """
        up, down = self._chain(frame), self._chain(reference)
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        if (up[-1].parent if up else frame) != (down[-1].parent if down else reference):
            tops = [
                chain[-1].parent if chain else it for it, chain in ((frame, up), (reference, down))
            ]
            raise TransformError(
                f"no transform connects {frame}, which is below {tops[0]}, with {reference},"
                f" which is below {tops[1]}"
            )
        moving = [it.stamps[-1] for it in (*up, *down) if not it.is_static]
        stamp_ns = min(moving, default=0)
        return StampedPose(
            _along(down, stamp_ns).inverse().after(_along(up, stamp_ns)), stamp_ns, stamp_ns
        )

    def _chain(self, frame: str) -> list[_Edge]:
        """Returns the transforms from a frame to the root, the frame's own first."""
        chain: list[_Edge] = []
        while (edge := self._edges.get(frame)) is not None:
            chain.append(edge)
            frame = edge.parent
            if len(chain) > len(self._edges):
                raise TransformError(f"the frame {frame} is its own ancestor")
        return chain


def _along(chain: list[_Edge], stamp_ns: int) -> Rigid:
    pose = Rigid()
    for edge in chain:
        pose = edge.at(stamp_ns).after(pose)
    return pose


def _transforms(payload: bytes) -> Iterator[tuple[str, str, int, Rigid]]:
    try:
        (count,) = _LENGTH.unpack_from(payload, _HEAD_BYTES)
        at = _HEAD_BYTES + _LENGTH.size
        for _ in range(count):
            at += -at % 4
            sec, nanosec = _TIME.unpack_from(payload, at)
            parent, at = _text(payload, at + _TIME.size)
            child, at = _text(payload, at + -at % 4)
            at += -(at - _HEAD_BYTES) % 8
            x, y, z, *rotation = _NUMBERS.unpack_from(payload, at)
            at += _NUMBERS.size
            i, j, k, w = rotation
            yield parent, child, sec * 1_000_000_000 + nanosec, Rigid((x, y, z), (i, j, k, w))
    except struct.error as error:
        raise ValueError(f"a TFMessage ends too early: {error}") from error


def _text(payload: bytes, at: int) -> tuple[str, int]:
    (length,) = _LENGTH.unpack_from(payload, at)
    begin = at + _LENGTH.size
    end = begin + length
    if end > len(payload):
        raise ValueError(f"a TFMessage ends before its byte {end}")
    return str(payload[begin : end - 1], "utf-8", "replace").lstrip("/"), end


def _unit(transform: Rigid) -> Rigid | None:
    (a, b, c), (x, y, z, w) = transform
    length = math.hypot(x, y, z, w)
    if not math.isfinite(length + a + b + c) or length < 1e-6:
        return None
    return Rigid(transform.translation, (x / length, y / length, z / length, w / length))


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Returns the rotation by `second`, and then by `first`."""
    x, y, z, w = first
    i, j, k, r = second
    return (
        w * i + x * r + y * k - z * j,
        w * j - x * k + y * r + z * i,
        w * k + x * j - y * i + z * r,
        w * r - x * i - y * j - z * k,
    )


def rotated(rotation: Quaternion, vector: Vector) -> Vector:
    """Returns a rotated vector."""
    x, y, z, w = rotation
    a, b, c = vector
    p, q, r = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (
        a + w * p + y * r - z * q,
        b + w * q + z * p - x * r,
        c + w * r + x * q - y * p,
    )


def between(first: Rigid, second: Rigid, share: float) -> Rigid:
    """Returns the transform at a share of the way from one to another: a slerp of rotations."""
    cosine = sum(a * b for a, b in zip(first.rotation, second.rotation, strict=True))
    sign = -1.0 if cosine < 0 else 1.0
    angle = math.acos(min(1.0, abs(cosine)))
    if angle < 1e-9:
        of_first, of_second = 1 - share, share
    else:
        of_first = math.sin((1 - share) * angle) / math.sin(angle)
        of_second = math.sin(share * angle) / math.sin(angle)
    x, y, z, w = (
        of_first * a + sign * of_second * b
        for a, b in zip(first.rotation, second.rotation, strict=True)
    )
    a, b, c = (
        (1 - share) * p + share * q
        for p, q in zip(first.translation, second.translation, strict=True)
    )
    return _unit(Rigid((a, b, c), (x, y, z, w))) or first
