"""The folder of the user's configuration, of the receiver's key and of the paired devices."""

import os
from pathlib import Path


def user_folder() -> Path:
    """Returns the folder `ml2-sensors` in XDG_CONFIG_HOME, or in ~/.config."""
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config", "ml2-sensors")
