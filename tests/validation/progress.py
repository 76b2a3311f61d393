"""Reports the progress of a long run."""

import sys
import time


def log_line(text: str) -> None:
    print(f"[{time.strftime('%H:%M:%S')}] {text}", file=sys.stderr, flush=True)
