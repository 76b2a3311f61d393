"""Android's adb, the user's own: this machine's way to a headset on a cable.

Where it reaches several devices, its own variable ANDROID_SERIAL chooses one.
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


def adb(*arguments: str, timeout_s: float = _TIMEOUT_S) -> str:
    """What adb prints.

    Raises:
        AdbError: it is missing, reaches no headset, or failed; with its words and what to do.
    """
    try:
        ended = subprocess.run(
            ["adb", *arguments],
            stdin=subprocess.DEVNULL,
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
    if ended.returncode != 0:
        words = ended.stderr.strip() or ended.stdout.strip() or "adb failed"
        raise AdbError(words, hint=_hint(words))
    return ended.stdout


def shell(*words: str) -> str:
    """What a command of the headset prints; its shell sees each of `words` as one.

    Raises:
        AdbError: as of `adb`, or the command failed.
    """
    return adb("shell", shlex.join(words))


def _hint(words: str) -> str:
    return next((text for symptom, text in _HINTS.items() if symptom in words), "")
