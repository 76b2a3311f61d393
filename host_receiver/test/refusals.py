"""Commands that end with an error, run in this process."""

from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

from ml2_receiver.cli import main


def refusal(*words: str | Path) -> str:
    """Runs a command, which has to end with exit code 2; returns what it says on standard error."""
    code: int | str | None
    with redirect_stderr(StringIO()) as said:
        try:
            code = main([str(word) for word in words])
        except SystemExit as ended:  # of argparse
            code = ended.code
    assert code == 2
    return said.getvalue()
