"""A receiver in this process, to which `ml2-receiver play` plays a recording."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bag_scene import REQUEST, battery, written
from fake_sink import FakeSink
from ml2_receiver.cli import main
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.sink import Sink
from ml2_receiver.session.streams import Request
from ml2_receiver.transport.access import Access, Everybody
from ml2_receiver.transport.listener import listen
from scene import PATIENT

CUSTOM = ("/p/custom/name", "/p/custom/thing")


def write_custom(folder: Path) -> Path:
    """A recording of two seconds of a topic whose type is known, and one of another."""
    messages = [(name, second, battery(second)) for second in (0, 1) for name in CUSTOM]
    return written(folder, messages, {CUSTOM[1]: "my_msgs/msg/Thing"})


@contextmanager
def receiving(
    sink: Sink, request: Request = REQUEST, access: Access | None = None
) -> Iterator[Server]:
    settings = ReceiverSettings("test", "test", limits=PATIENT)
    server = Server(listen(("127.0.0.1", 0)), access or Everybody(), sink, request, settings)
    server.start()
    try:
        yield server
    finally:
        server.stop()


def to(server: Server) -> tuple[str, ...]:
    """Options to play to a receiver without TLS."""
    return "--receiver", server.address, "--insecure"


def play(bag: Path, server: Server, *options: str) -> int:
    return main(["play", str(bag), *to(server), *options])


def played(
    bag: Path,
    request: Request = REQUEST,
    *options: str,
    code: int = 0,
    sink: FakeSink | None = None,
) -> FakeSink:
    """Plays a recording to the end of its session; returns what the receiver got."""
    sink = sink or FakeSink()
    with receiving(sink, request) as server:
        assert play(bag, server, *options) == code
        sink.await_report()
    return sink
