"""YAML as OpenCV's cv::FileStorage reads it, which ORB-SLAM3, OpenVINS and readers of EuRoC use."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml


def asl_yaml(document: Mapping[str, Any]) -> str:
    """With the first line that OpenCV wants, which is no directive of YAML."""
    text = yaml.dump(dict(document), Dumper=_Dumper, sort_keys=False, default_flow_style=None)
    return f"%YAML:1.0\n---\n{text}"


class _Dumper(yaml.SafeDumper):
    """OpenCV wants lists deeper than their key, and reads no line that is broken or an alias.

    Lists of numbers are on one line, keys on lines of their own.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options | {"width": 10_000})

    def represent_mapping(self, tag: str, mapping: Any, flow_style: Any = None) -> yaml.MappingNode:
        return super().represent_mapping(tag, mapping, flow_style=False)

    def increase_indent(self, flow: bool = False, indentless: bool = False) -> None:
        super().increase_indent(flow, False)

    def ignore_aliases(self, data: Any) -> bool:
        return True
