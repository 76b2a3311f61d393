import signal

import pytest

from ros_processes import Child

# The kernel may give a signal to any thread; here it cannot give it to the one that waits.
PROGRAM = """
import signal
import threading
from ml2_receiver.commands.stopping import stop_signal

stopping = stop_signal()
threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
print("waits", flush=True)
stopping.wait()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_that_another_thread_gets_ends_the_wait(number: signal.Signals) -> None:
    with Child("-c", PROGRAM) as child:
        assert child.line() == "waits"
        assert child.end(number) == 0
