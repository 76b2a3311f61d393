"""What `ml2-receiver products` makes of a rendered room, looked at by programs of others."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from capture_stamps import stamp_ns
from markers import corners
from processes import (
    EXCERPT,
    PREFIX,
    RECEIVER,
    Received,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
)
