"""Writes YAML for OpenCV's cv::FileStorage, which ORB-SLAM3, OpenVINS and EuRoC readers use."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from ..geometry.pose import Pose


@dataclass(frozen=True)
class OpenCvMatrix:
    """A pose as OpenCV writes matrices, with their sizes and type."""

    pose: Pose


def asl_yaml(document: Mapping[str, Any]) -> str:
    """Returns the YAML text, with the first line that OpenCV needs (not a YAML directive)."""
    text = yaml.dump(dict(document), Dumper=_Dumper, sort_keys=False, default_flow_style=None)
    return f"%YAML:1.0\n---\n{text}"


class _Dumper(yaml.SafeDumper):
    """A YAML dumper for OpenCV, which needs indented lists and reads no wrapped lines or aliases.

    A list of numbers is on one line; each key has its own line.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options | {"width": 10_000})

    def represent_mapping(self, tag: str, mapping: Any, flow_style: Any = None) -> yaml.MappingNode:
        return super().represent_mapping(tag, mapping, flow_style=False)

    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, False)

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_matrix(self, matrix: OpenCvMatrix) -> yaml.MappingNode:
        values = {"rows": 4, "cols": 4, "dt": "d", "data": matrix.pose.ravel().tolist()}
        return self.represent_mapping("tag:yaml.org,2002:opencv-matrix", values)


_Dumper.add_representer(OpenCvMatrix, _Dumper.represent_matrix)
