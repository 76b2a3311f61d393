"""How tests share the machine."""

from shared_machine import in_turns

pytest_runtest_protocol = in_turns(places=2)
