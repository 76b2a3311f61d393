import signal
import sys

# Ctrl-C while modules are imported ends the process without a traceback.
signal.signal(signal.SIGINT, signal.SIG_DFL)

from .cli import main  # noqa: E402

if __name__ == "__main__":
    sys.exit(main())
