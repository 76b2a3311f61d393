import signal
import sys

# Ctrl-C until the command line heeds it ends the process without a traceback. The script
# ml2-receiver starts Python with the signal blocked, so that it waits until here.
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

from .cli import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
