"""Children of tests: the receiver and ROS programs, in a ROS domain of this process's own."""

import functools
import json
import os
import queue
import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from forked import ForkedPython
from ros_domain import reserve_domain
from waiting import GRACE_S, LIMIT_S

_POLL_S = 0.01
_HERE = Path(__file__).parent
_own_domain = functools.cache(reserve_domain)


def environment() -> dict[str, str]:
    """Returns the environment for children."""
    environ = {**os.environ, "PYTHONPATH": str(_HERE.parent), "PYTHONUNBUFFERED": "1"}
    environ["PYTHONFAULTHANDLER"] = "1"
    environ["ROS_DOMAIN_ID"] = str(_own_domain())
    environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    return environ


def segments(process: int) -> list[Path]:
    """A process's own shared memory. It maps that of others, too, and locks none of it."""
    maps = Path(f"/proc/{process}/maps").read_text()
    mapped = set(re.findall(r"/dev/shm/fastrtps_(?!port)\w+", maps))
    open_files = set()
    for descriptor in Path(f"/proc/{process}/fd").iterdir():
        with suppress(FileNotFoundError):  # it has just been closed
            open_files.add(str(descriptor.readlink()))
    return [Path(name) for name in mapped if f"{name}_el" in open_files]


class Child:
    """A Python program whose standard output is read line by line.

    When left, it is interrupted, terminated if it goes on, and killed as a last resort: a ROS
    program that is killed stays in the others' graphs for many seconds.

    Args:
        program: what it starts.
    """

    def __init__(self, *arguments: str, program: str = sys.executable) -> None:
        environ = environment()
        # A library to load first takes part in the start, and a program of a test in the imports.
        is_fresh = program != sys.executable or arguments[0] == "-c" or "LD_PRELOAD" in environ
        self.process = (subprocess.Popen if is_fresh else ForkedPython)(
            [program, *arguments],
            env=environ,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.errors: list[str] = []
        self._lines: queue.Queue[str] = queue.Queue()
        self._threads = [
            threading.Thread(target=self._read, args=[self.process.stdout, self._lines.put]),
            threading.Thread(target=self._read, args=[self.process.stderr, self.errors.append]),
        ]
        for thread in self._threads:
            thread.start()

    @staticmethod
    def _read(stream: Any, take: Any) -> None:
        for line in stream:
            take(line.rstrip("\n"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._stop()
        finally:
            self.process.kill()
            self.process.wait()
        for thread in self._threads:
            thread.join()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            assert stream is not None
            stream.close()
        print(*self.errors, sep="\n", file=sys.stderr)  # which pytest shows if the test failed

    def _stop(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            self.process.send_signal(number)
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(GRACE_S)
                return
        raise AssertionError(
            f"neither SIGINT nor SIGTERM ends {self.process.args!r}; {self.errors}"
        )

    def line(self, timeout_s: float = LIMIT_S) -> str:
        """The next line; when none comes, the program is left, and says where its threads are."""
        try:
            return self._lines.get(timeout=timeout_s)
        except queue.Empty:
            self.process.send_signal(signal.SIGABRT)
            self.__exit__()  # for in a constructor nobody else would
            errors = "\n".join(self.errors)
            raise AssertionError(f"no line within {timeout_s} s; {errors}") from None

    def object(self, timeout_s: float = LIMIT_S) -> Any:
        """The next line, which is JSON."""
        return json.loads(self.line(timeout_s))

    def has_line(self, timeout_s: float) -> bool:
        """Returns True if a matching line comes, and takes it."""
        try:
            self._lines.get(timeout=timeout_s)
        except queue.Empty:
            return False
        return True

    def await_error(self, text: str, timeout_s: float = LIMIT_S) -> None:
        """Waits for a line of standard error with this text."""
        deadline_s = time.monotonic() + timeout_s
        while not any(text in line for line in self.errors):
            assert time.monotonic() < deadline_s, self.errors
            time.sleep(_POLL_S)

    def end(self, number: int = signal.SIGINT) -> int:
        """The exit code after a signal."""
        self.process.send_signal(number)
        return self.wait()

    def wait(self) -> int:
        """The exit code."""
        code = self.process.wait(LIMIT_S)
        for thread in self._threads:
            thread.join()
        return code


class Receiver(Child):
    """`ml2-receiver run` on a port the system chose, in plaintext; `address` is where."""

    def __init__(self, config: Path, *options: str) -> None:
        listen = ("--config", str(config), "--listen", "127.0.0.1:0", "--insecure")
        super().__init__("-m", "ml2_receiver", "run", *listen, *options)
        self.address = self.line().removeprefix("listening on ")


class Recording(Child):
    """`ml2-receiver record` into a folder, as Receiver."""

    def __init__(self, folder: Path, config: Path, *options: str) -> None:
        listen = ("--config", str(config), "--listen", "127.0.0.1:0", "--insecure")
        super().__init__("-m", "ml2_receiver", "record", str(folder), *listen, *options)
        self.address = self.line().removeprefix("listening on ")
        line = self.line()
        assert line.startswith(f"recording into {folder} "), line
        assert line.endswith("until Ctrl-C"), line


class Subscriber(Child):
    """Sees one topic: first `publisher`, then messages; see ros_subscriber.py."""

    def __init__(self, topic: str, type: str, durability: str = "volatile") -> None:
        super().__init__(str(_HERE / "ros_subscriber.py"), topic, type, durability)
        self.publisher = self.object()

    def message(self) -> bytes:
        return bytes.fromhex(self.object())


class Client(Child):
    """Calls the receiver's services as another node would; see ros_client.py."""

    def __init__(self) -> None:
        super().__init__(str(_HERE / "ros_client.py"))

    def ask(self, function: str, *arguments: Any) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps([function, *arguments]) + "\n")
        self.process.stdin.flush()
        return self.object()
