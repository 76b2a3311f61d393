"""Android's adb, the user's own: this machine's way to a headset on a cable.

Where it reaches several devices, its own variable ANDROID_SERIAL chooses one.
"""

import shlex
import subprocess

from ..errors import AdbError

_TIMEOUT_S = 20.0
_MISSING = (
    "adb is not on PATH: `sudo apt install adb`, or unpack"
    " https://developer.android.com/tools/releases/platform-tools"
)
_ADVICE = {
    "no devices": "connect the headset by USB-C and switch on USB debugging (Settings, Developer"
    " options)",
    "unauthorized": "put the headset on and allow this PC there",
    "offline": "unplug the cable and plug it in again",
    "more than one device": "choose one: ANDROID_SERIAL=... before the command, see `adb devices`",
    "UPDATE_INCOMPATIBLE": "an app signed by another key is installed; `adb uninstall"
    " dev.ml2sensors.app` removes it, with its pairings",
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
        raise AdbError(_MISSING) from error
    except subprocess.TimeoutExpired as error:
        raise AdbError(f"adb {arguments[0]} did not end within {timeout_s:.0f} s") from error
    if ended.returncode != 0:
        raise AdbError(_with_advice(ended.stderr.strip() or ended.stdout.strip() or "adb failed"))
    return ended.stdout


def shell(*words: str) -> str:
    """What a command of the headset prints; its shell sees each of `words` as one.

    Raises:
        AdbError: as of `adb`, or the command failed.
    """
    return adb("shell", shlex.join(words))


def _with_advice(words: str) -> str:
    advice = next((text for symptom, text in _ADVICE.items() if symptom in words), "")
    return f"{words}\n{advice}" if advice else words
