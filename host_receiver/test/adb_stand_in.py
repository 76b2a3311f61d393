"""A headset behind adb, as strict as both: a command they do not have ends the test.

It is the program `adb` of a test; its folder ADB_STAND_IN has `state.json`, `words` with a line for
each call, and `calls` with the same, but what the headset's shell reads from standard input stands
there as a word. Words behind `shell` are joined by spaces and split again by the headset's shell,
as adb does it. Android's log has the app's answers, and in `warnings` of the state what the library
says.
"""

import json
import os
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

APP = "dev.ml2sensors.app"
# Answers of the app, checked by its own test.
STATUS = Path(__file__).parents[2] / "ml2-sensors-aar/app/src/test/resources/status.jsonl"
SERIAL = "G5A0STANDIN"
# The lines of the state that logcat shows, by its format and filter.
LOGS = {"raw -s ml2-sensors:I": "log", "time -s ml2s": "warnings"}


def installed(folder: Path, **state: Any) -> dict[str, str]:
    """Makes the program in `folder`; returns the variables with which it is the user's adb."""
    program = folder / "bin" / "adb"
    program.parent.mkdir()
    words = shlex.join((sys.executable, __file__))
    program.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    program.chmod(0o755)
    (folder / "state.json").write_text(json.dumps(state))
    return {"ADB_STAND_IN": str(folder), "PATH": f"{program.parent}:{os.environ['PATH']}"}


class Headset:
    """The state in `state.json`, during one call."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "state.json"
        self.state: dict[str, Any] = json.loads(self.file.read_text())

    def keep(self) -> None:
        self.file.write_text(json.dumps(self.state))

    def install(self, apk: str) -> None:
        if self.state.get("signature") == "other":
            _fail(
                f"adb: failed to install {apk}: Failure [INSTALL_FAILED_UPDATE_INCOMPATIBLE:"
                f" Package {APP} signatures do not match previously installed version; ignoring!]"
            )
        self.state["installed"] = True
        print("Performing Streamed Install\nSuccess")

    def grant(self, package: str, permission: str) -> None:
        if permission in self.state.get("unknown", ()):
            _fail(f"\nException occurred while executing:\nUnknown permission: {permission}", 255)
        assert package == APP
        self.state.setdefault("granted", []).append(permission)

    def start_service(self, words: list[str]) -> None:
        options = _options(words)
        assert options.pop("-n") == f"{APP}/.StreamingService"
        action = options.pop("-a").removeprefix(f"{APP}.")
        print(f"Starting service: Intent {{ act={APP}.{action} (has extras) }}")
        if not self.state.get("installed", True):
            print("Error: Not found; no service started.")
            return
        self.log(action, options)

    def log(self, action: str, extras: dict[str, str]) -> None:
        request = extras.pop("request")
        expected = {"PAIR": {"uri"}, "RECEIVER": {"receiver"}}
        assert set(extras) == expected.get(action, set()), f"{action} with {sorted(extras)}"
        lines = self.state.setdefault("log", [])
        if action == "STATUS":
            state = self.state.get("states", ["connected"])
            answers = [json.loads(line) for line in STATUS.read_text().splitlines()]
            answers[0]["status"]["state"] = state.pop(0) if len(state) > 1 else state[0]
            lines += [json.dumps(it | {"request": request}) for it in answers]
        elif self.state.get("error"):
            lines.append(json.dumps({"request": request, "more": 0, "error": self.state["error"]}))
        elif not self.state.get("silent"):
            lines.append(json.dumps({"request": request, "more": 0}))


def main(words: list[str]) -> None:
    folder = Path(os.environ["ADB_STAND_IN"])
    with (folder / "words").open("a") as seen:
        seen.write(json.dumps(words) + "\n")
    if words == ["shell", "sh"]:
        words = ["shell", sys.stdin.read().removesuffix("\n")]
    with (folder / "calls").open("a") as calls:
        calls.write(json.dumps(words) + "\n")
    headset = Headset(folder)
    if failure := headset.state.get("failure"):
        _fail(failure)
    match words:
        case ["install", "-r", apk]:
            headset.install(apk)
        case ["reverse", here, there]:
            assert {here[:4], there[:4]} == {"tcp:"}
        case ["get-serialno"]:
            print(SERIAL)
        case ["logcat", "-d", "-v", *rest] if " ".join(rest) in LOGS:
            lines = headset.state.get(LOGS[" ".join(rest)], ())
            print("--------- beginning of main", *lines, sep="\n")
        case ["shell", *rest]:
            match shlex.split(" ".join(rest)):
                case ["pm", "grant", package, permission]:
                    headset.grant(package, permission)
                case ["am", "start-foreground-service", *options]:
                    headset.start_service(options)
                case other:
                    _fail(f"/system/bin/sh: {other[:1]}: not found", 127)
        case _:
            _fail(f"adb: unknown command {words[0]}")
    headset.keep()


def _options(words: list[str]) -> dict[str, str]:
    """Returns the component, the action and the text extras in arguments of `am`."""
    found = {}
    rest: Iterator[str] = iter(words)
    for word in rest:
        assert word in ("-n", "-a", "--es"), f"am has no {word}"
        name = next(rest) if word == "--es" else word
        found[name] = next(rest)
    return found


def _fail(message: str, code: int = 1) -> NoReturn:
    print(message, file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main(sys.argv[1:])
