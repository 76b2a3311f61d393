"""The cases of vectors/axes: one pose in the axes that the headset, ROS, cameras and Unity use.

poses.json is a list of {"ml", "ros", "optical", "unity"}, each {"position": [x, y, z], "rotation":
[x, y, z, w]}. `ml` and `unity` have their axes for world and thing, `ros` REP-103 body axes for
both, `optical` body axes for the world and optical ones for the thing. A rotation and its negative
are the same. All come from 3x3 matrices of axes, and from no code of the product.
"""

import json
import math
import random

Matrix = list[list[float]]
Case = dict[str, dict[str, list[float]]]

# The axes of one system in those of another, as rows.
ROS_FROM_ML: Matrix = [[0, 0, -1], [-1, 0, 0], [0, 1, 0]]
UNITY_FROM_ML: Matrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]
ML_FROM_OPTICAL: Matrix = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]


def files() -> dict[str, bytes]:
    half = math.sqrt(0.5)
    cases = [
        _case([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]),
        _case([0.0, 0.0, 0.0], [0.0, half, 0.0, half]),
        _case([0.0, 0.0, 0.0], [half, 0.0, 0.0, half]),
        _case([0.0, 0.0, 0.0], [0.0, 0.0, half, half]),
    ]
    source = random.Random(3)
    cases += [_case(_vector(source, 3), _unit(_vector(source, 4))) for _ in range(20)]
    return {"poses.json": (json.dumps(cases, indent=1) + "\n").encode()}


def _case(position: list[float], rotation: list[float]) -> Case:
    turn = _matrix(rotation)
    in_ros = _product(ROS_FROM_ML, turn)
    in_unity = _product(UNITY_FROM_ML, turn)
    return {
        "ml": _pose(position, turn),
        "ros": _pose(_apply(ROS_FROM_ML, position), _product(in_ros, _transposed(ROS_FROM_ML))),
        "optical": _pose(_apply(ROS_FROM_ML, position), _product(in_ros, ML_FROM_OPTICAL)),
        "unity": _pose(
            _apply(UNITY_FROM_ML, position), _product(in_unity, _transposed(UNITY_FROM_ML))
        ),
    }


def _pose(position: list[float], turn: Matrix) -> dict[str, list[float]]:
    return {"position": position, "rotation": _quaternion(turn)}


def _vector(source: random.Random, count: int) -> list[float]:
    return [source.uniform(-1, 1) for _ in range(count)]


def _unit(values: list[float]) -> list[float]:
    return [value / math.hypot(*values) for value in values]


def _apply(matrix: Matrix, vector: list[float]) -> list[float]:
    return [sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix]


def _product(left: Matrix, right: Matrix) -> Matrix:
    return _transposed([_apply(left, column) for column in _transposed(right)])


def _transposed(matrix: Matrix) -> Matrix:
    return [list(column) for column in zip(*matrix, strict=True)]


def _matrix(q: list[float]) -> Matrix:
    x, y, z, w = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def _quaternion(m: Matrix) -> list[float]:
    """Each squared component stands on the diagonal; the largest one says the signs of the rest."""
    trace = m[0][0] + m[1][1] + m[2][2]
    squares = [(1 + 2 * m[i][i] - trace) / 4 for i in range(3)] + [(1 + trace) / 4]
    largest = squares.index(max(squares))
    a, b, c = m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]
    ab, ac, bc = m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]
    products = [
        [4 * squares[0], ab, ac, a],
        [ab, 4 * squares[1], bc, b],
        [ac, bc, 4 * squares[2], c],
        [a, b, c, 4 * squares[3]],
    ][largest]
    return [value / (4 * math.sqrt(squares[largest])) for value in products]
