"""YAML as ROS 2 reads it: a tree, in which nothing stands for something elsewhere."""

from typing import Any

import yaml
from yaml.composer import ComposerError
from yaml.nodes import Node


class TreeLoader(yaml.SafeLoader):
    """No aliases: a few bytes of them can stand for gigabytes."""

    def compose_node(self, parent: Node | None, index: Any) -> Node | None:
        if self.check_event(yaml.AliasEvent):
            mark = self.get_event().start_mark  # type: ignore[no-untyped-call]
            raise ComposerError(None, None, "found an alias, which ROS 2 does not read", mark)
        return super().compose_node(parent, index)
