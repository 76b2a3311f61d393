"""Runs the user's adb, which reaches a headset over a cable.

If adb reaches several devices, its environment variable ANDROID_SERIAL chooses one.
"""

import shlex
import subprocess

from ..errors import AdbError

_TIMEOUT_S = 20.0
_INSTALL_ADB = (
    "Run `sudo apt install adb`, or unpack"
    " https://developer.android.com/tools/releases/platform-tools."
)
_HINTS = {
    "no devices": "Connect the headset by USB-C, and switch on USB debugging (Settings, Developer"
    " options).",
    "unauthorized": "Put the headset on and allow this PC there.",
    "offline": "Unplug the cable and plug it in again.",
    "more than one device": "Choose one of `adb devices`: put ANDROID_SERIAL=... before the"
    " command.",
    "UPDATE_INCOMPATIBLE": "The installed app is signed by another key. `adb uninstall"
    " dev.ml2sensors.app` removes it with its pairings.",
}


def adb(*arguments: str, timeout_s: float = _TIMEOUT_S, typed: str = "") -> str:
    """Runs adb and returns its output.

    Args:
        typed: what it reads on standard input.

    Raises:
        AdbError: adb is missing, reaches no headset, or failed. The message is adb's own.
    """
    try:
        completed = subprocess.run(
            ["adb", *arguments],
            input=typed,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=timeout_s,
            check=False,
        )
    except FileNotFoundError as error:
        raise AdbError("adb is not installed, or not on PATH", hint=_INSTALL_ADB) from error
    except subprocess.TimeoutExpired as error:
        raise AdbError(
            f"adb {arguments[0]} did not end within {timeout_s:.0f} s",
            hint="Unplug the cable and plug it in again, and run `adb kill-server`.",
        ) from error
    if completed.returncode != 0:
        words = completed.stderr.strip() or completed.stdout.strip() or "adb failed"
        raise AdbError(words, hint=_hint(words))
    return completed.stdout


def shell(*words: str) -> str:
    """Runs a command on the headset and returns its output.

    The headset's shell takes each of `words` as one argument.

    Raises:
        AdbError: adb or the command failed.
    """
    return adb("shell", shlex.join(words))


def secret_shell(*words: str) -> str:
    """Works as shell(), but no other user of this machine can read the words.

    Raises:
        AdbError: adb or the command failed.
    """
    return adb("shell", "sh", typed=f"{shlex.join(words)}\n")


def _hint(words: str) -> str:
    return next((text for symptom, text in _HINTS.items() if symptom in words), "")
