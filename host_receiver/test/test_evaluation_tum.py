"""TUM files, written and read back."""

import os
from pathlib import Path

import numpy as np
import pytest

from ml2_tools.errors import EvaluationError
from ml2_tools.evaluation.tum import read_tum, write_tum
from trajectories import START_NS, wandering


def test_a_trajectory_comes_back_with_every_nanosecond(tmp_path: Path) -> None:
    written = wandering()
    write_tum(tmp_path / "it.tum", written)
    read = read_tum(tmp_path / "it.tum")
    assert [at for at, _ in read] == [at for at, _ in written]
    np.testing.assert_allclose([it for _, it in read], [it for _, it in written], atol=2e-8)


def test_the_columns_are_those_of_the_format(tmp_path: Path) -> None:
    quarter_turn_left = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1.0]])
    write_tum(tmp_path / "it.tum", [(START_NS, quarter_turn_left)])
    words = (tmp_path / "it.tum").read_text().split()
    assert words[0] == "1700000000.123456789"
    expected = [1, 2, 3, 0, 0, 0.5**0.5, 0.5**0.5]
    np.testing.assert_allclose([float(it) for it in words[1:]], expected, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 2 3", ":1: expected 8 numbers"),
        ("# fine\n1 0 0 0 0 0 0 5", ":2: expected a unit quaternion"),
        ("1 nan 0 0 0 0 0 1", ":1: expected a unit quaternion and finite metres"),
        ("one 0 0 0 0 0 0 1", ":1: "),
    ],
)
def test_a_wrong_line_is_told(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "it.tum").write_text(text)
    with pytest.raises(EvaluationError, match=said):
        read_tum(tmp_path / "it.tum")


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(EvaluationError, match="No such file"):
        read_tum(tmp_path / "none.tum")


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(EvaluationError, match="pipe: expected a regular file"):
        read_tum(tmp_path / "pipe")
