"""The two layouts of the transform tree."""

import numpy as np
import pytest
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from camera_messages import stamped, transform_of
from ml2_tools.geometry.transform_tree import Tree

TREE = {"world": "magicleap_world", "head": "head_frame"}


def transform(
    parent: str, child: str, x: float, stamp_s: int = 0, w: float = 1
) -> TransformStamped:
    return transform_of(stamped(parent, stamp_s * 10**9), child, (x, 0, 0), (0, 0, 0, w))


def tree() -> Tree:
    return Tree({"color_optical_frame": "color"}, **TREE)


def found(tree: Tree, *transforms: TransformStamped) -> list[tuple[str, int, float]]:
    poses = tree.poses(TFMessage(transforms=list(transforms)))
    return [(camera, stamp_ns, float(pose[0, 3])) for camera, stamp_ns, pose in poses]


def test_a_camera_is_a_child_of_the_world() -> None:
    seen = transform("magicleap_world", "color_optical_frame", 3, 7)
    others = [
        transform("magicleap_world", "color_frame", 1),
        transform("odom", "color_optical_frame", 1),
        transform("magicleap_world", "head_frame", 1),
    ]
    assert found(tree(), *others, seen) == [("color", 7_000_000_000, 3)]


def test_a_camera_of_a_rig_is_where_the_head_is() -> None:
    rig = tree()
    mounting = [
        transform("head_frame", "color_frame", 1),
        transform("color_frame", "color_optical_frame", 0.5),
    ]
    rig.stand(TFMessage(transforms=mounting))
    assert found(rig, transform("magicleap_world", "head_frame", 3, 7)) == [
        ("color", 7_000_000_000, 4.5)
    ]


def test_static_transforms_of_other_nodes_take_none_away() -> None:
    rig = tree()
    rig.stand(TFMessage(transforms=[transform("color_frame", "color_optical_frame", 0.5)]))
    rig.stand(TFMessage(transforms=[transform("base_link", "lidar", 9, w=np.nan)]))
    rig.stand(TFMessage(transforms=[transform("head_frame", "color_frame", 1)]))
    assert found(rig, transform("magicleap_world", "head_frame", 3, 7)) == [
        ("color", 7_000_000_000, 4.5)
    ]


def test_the_newest_transform_of_a_frame_counts() -> None:
    rig = tree()
    head = transform("magicleap_world", "head_frame", 3, 7)
    for x in (0.5, 0.25):
        rig.stand(TFMessage(transforms=[transform("head_frame", "color_optical_frame", x)]))
    assert found(rig, head) == [("color", 7_000_000_000, 3.25)]
    flat = transform("magicleap_world", "color_optical_frame", 5, 8)
    assert found(rig, flat, head) == [("color", 8_000_000_000, 5)]


def test_static_transforms_that_form_a_circle_lead_nowhere() -> None:
    rig = tree()
    circle = [
        transform("a", "color_optical_frame", 1),
        transform("color_optical_frame", "a", 1),
    ]
    rig.stand(TFMessage(transforms=circle))
    assert not found(rig, transform("magicleap_world", "head_frame", 3, 7))


def test_what_is_no_rotation_is_refused() -> None:
    wrong = transform("magicleap_world", "color_optical_frame", 0, w=np.nan)
    with pytest.raises(ValueError, match="unit quaternion"):
        found(tree(), wrong)


def test_static_transforms_of_more_than_a_thousand_frames_are_ignored() -> None:
    rig = tree()
    rig.stand(TFMessage(transforms=[transform("head_frame", "color_optical_frame", 1)]))
    many = [transform("base_link", f"tag_{number}", 0) for number in range(1000)]
    rig.stand(TFMessage(transforms=[*many, transform("head_frame", "color_optical_frame", 2)]))
    head = transform("magicleap_world", "head_frame", 3, 7)
    assert found(rig, head) == [("color", 7_000_000_000, 5)]
    full = tree()
    full.stand(TFMessage(transforms=many))
    full.stand(TFMessage(transforms=[transform("head_frame", "color_optical_frame", 1)]))
    assert found(full, head) == []
