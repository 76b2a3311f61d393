"""Python programs that start at once: forks of a process that has imported the receiver and ROS.

Each is a child of this process like a fresh one, with a command line, an environment and standard
streams of its own. Tests of what happens while Python starts or imports start Python itself.
"""

import atexit
import ctypes
import functools
import gc
import importlib
import inspect
import io
import json
import os
import pkgutil
import re
import runpy
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path
from typing import Any

from waiting import GRACE_S

_SET_CHILD_SUBREAPER = 36
_MOST_BYTES = 1 << 17
# The modules that these do not import are large, and few programs need them.
_TOOLS = ("bags", "commands", "live", "monitoring", "viewing")
_PACKAGES = ("ml2_receiver", *(f"ml2_tools.{it}" for it in _TOOLS))
_one_at_a_time = threading.Lock()


class _Written(io.FileIO):
    """A file each of whose writes is whole."""

    def write(self, data: Any) -> int:
        """Writes all, also when a standstill of the process ends the wait for a full pipe."""
        left = memoryview(data)
        while left:
            left = left[super().write(left) or 0 :]
        return len(data)


class ForkedPython(subprocess.Popen[str]):
    """`python3 -m MODULE ...` or `python3 FILE ...`; its `args` begin with that Python.

    With `network`, it runs in the network that `ip netns` has by that name.
    """

    def __init__(self, args: list[str], *, network: str = "", **options: Any) -> None:
        self._network = network
        super().__init__(args, **options)

    def _execute_child(self, args: list[str], *given: Any) -> None:
        _, _, _, _, cwd, environ, _, _, _, *pipes = given
        # Inherited, unless others are given
        streams = [it if it != -1 else n for n, it in enumerate((pipes[0], pipes[3], pipes[5]))]
        folder, environ = str(cwd or Path.cwd()), environ or {**os.environ}
        request = json.dumps([args, folder, environ, self._network]).encode()
        with _one_at_a_time:
            server = _server()
            # The fork is orphaned at once, so it becomes a child of this process.
            _adopt_orphans(True)
            try:
                socket.send_fds(server, [request], streams)
                pid, is_orphaned = server.recv(_MOST_BYTES), server.recv(_MOST_BYTES)
            finally:
                _adopt_orphans(False)
        if not is_orphaned:
            raise RuntimeError("the process that forks Python programs has ended; stderr says why")
        self.pid = int(pid)
        self._child_created = True
        self._close_pipe_fds(*pipes[:6])  # type: ignore[attr-defined]


def _adopt_orphans(adopts: bool) -> None:
    if ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, int(adopts), 0, 0, 0):
        raise OSError("prctl(PR_SET_CHILD_SUBREAPER) failed")


@functools.cache
def _server() -> socket.socket:
    """Starts the process that forks, and returns the connection to it, with which it ends."""
    ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    environ = {
        **os.environ,
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONFAULTHANDLER": "1",
        "PYTHONPATH": str(Path(__file__).parents[1]),
        # Its forks write theirs over long ones.
        "ROOM": " " * 8192,
    }
    with its:
        command = [sys.executable, __file__, str(its.fileno()), " " * 4096]
        server = subprocess.Popen(
            command, env=environ, pass_fds=[its.fileno()], stdin=subprocess.DEVNULL
        )
    atexit.register(server.wait)
    atexit.register(ours.close)  # before that
    return ours


def _import_all() -> None:
    for package in map(importlib.import_module, _PACKAGES):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)


def _load_type_supports() -> None:
    """Loads the libraries of the messages and services that nodes mostly have."""
    load = importlib.import_module("rclpy.type_support").check_for_type_support
    streams = importlib.import_module("ml2_receiver.table.reader").load_table().streams.values()
    message_class = importlib.import_module("ml2_receiver.topics.message_types").message_class
    for type in {topic.type for stream in streams for topic in stream.topics}:
        load(message_class(type))
    services = importlib.import_module("rcl_interfaces.srv")
    for service in (it for it in vars(services).values() if inspect.isclass(it)):
        load(service)


def _serve(connection: socket.socket) -> tuple[bytes, list[int]]:
    """Forks for each request, and returns it in the fork.

    It forks as programs do that LTTng traces: then its threads hold no lock, and start in the fork.
    """
    tracing = _tracing()
    while True:
        request, streams, _, _ = socket.recv_fds(connection, _MOST_BYTES, 3)
        if not request:
            sys.exit()
        signals = ctypes.create_string_buffer(128)
        tracing["before_fork"](signals)
        with warnings.catch_warnings(action="ignore"):  # which say that there are threads
            between = os.fork()
        if between == 0:
            # It has no threads, of which its fork could inherit a lock.
            if child := os.fork():
                connection.send(str(child).encode())
                os._exit(0)
            tracing["after_fork_child"](signals)
            return request, streams
        tracing["after_fork_parent"](signals)
        for stream in streams:
            os.close(stream)
        os.waitpid(between, 0)
        connection.send(b"orphaned")


def _tracing() -> dict[str, Any]:
    """Returns the functions for forks of LTTng, which rclpy loads and which has threads."""
    loaded = re.search(r"/.*/liblttng-ust(-[0-9a-f]{8})?\.so\S*", _own("maps").read_text())
    library = ctypes.CDLL(loaded[0] if loaded else None)
    return {
        it: getattr(library, f"lttng_ust_{it}", None) or getattr(library, f"ust_{it}")
        for it in ("before_fork", "after_fork_parent", "after_fork_child")
    }


def _own(file: str) -> Path:
    return Path("/proc/self", file)


def _show(command: list[str], environ: dict[str, str]) -> None:
    """Writes the command line and the environment that other processes see."""
    fields = _own("stat").read_text().rpartition(")")[2].split()
    variables = ["=".join(it) for it in environ.items()]
    for strings, ends in ((command, fields[45:47]), (variables, fields[47:49])):
        begin, end = map(int, ends)
        text = b"".join(os.fsencode(it) + b"\0" for it in strings)
        if len(text) > end - begin:
            raise ValueError(f"{end - begin} bytes have no room for {strings}")
        ctypes.memmove(begin, text.ljust(end - begin, b"\0"), end - begin)


def _become(command: list[str], folder: str, environ: dict[str, str], streams: list[int]) -> None:
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    sys.stdin = os.fdopen(0, closefd=False)
    for number, name in enumerate(("stdout", "stderr"), 1):
        like = getattr(sys, name)
        file = _Written(number, "w", closefd=False)
        text = io.TextIOWrapper(file, like.encoding, like.errors, "\n", write_through=True)
        setattr(sys, name, text)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environ)
    _show(command, environ)  # into memory of the environment before
    time.tzset()
    sys.modules["numpy"].random.seed()
    sys.argv = command[1:]


def _threads() -> int:
    return len(list(_own("task").iterdir()))


def main() -> None:
    heard = signal.signal(signal.SIGINT, signal.SIG_IGN)
    importlib.import_module("rclpy")
    of_tracing = _threads()
    _import_all()
    _load_type_supports()
    if _threads() != of_tracing:
        raise RuntimeError("a module starts a thread, which forks would not have")
    # It only ends what hangs, and a full machine stops slowly. Programs given with -c keep it.
    vars(sys.modules["ml2_receiver.stop_limit"])["STOP_S"] = GRACE_S
    gc.freeze()  # so that forks share what was imported
    with socket.socket(fileno=int(sys.argv[1])) as connection:
        request, streams = _serve(connection)
    command, folder, environ, network = json.loads(request)
    if network:
        with Path("/run/netns", network).open() as file:
            os.setns(file, os.CLONE_NEWNET)
    _become(command, folder, environ, streams)
    signal.signal(signal.SIGINT, heard)
    is_module = sys.argv[0] == "-m"
    if is_module:
        del sys.argv[0]
    # The first two are the folder of this file and what _server() gives.
    first = folder if is_module else str(Path(sys.argv[0]).parent)
    sys.path[:2] = [first, *environ.get("PYTHONPATH", "").split(os.pathsep)]
    if is_module:
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    else:
        runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
