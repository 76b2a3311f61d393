"""How tests share the machine."""

from pathlib import Path

from shared_machine import in_turns

pytest_runtest_protocol = in_turns(Path(__file__).parent, places=1)
