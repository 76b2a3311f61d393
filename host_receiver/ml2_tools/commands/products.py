"""ml2-receiver products: makes point clouds, registered depth, rectified and raw images."""

import argparse

from ml2_receiver.commands.options import Subparsers, add_receiver
from ml2_receiver.commands.ros_start import node_arguments, ros_needed
from ml2_receiver.commands.stopping import stop_signal

from .optional_packages import optional_packages

_EPILOG = """\
Run it next to `ml2-receiver run`, or while a bag is played. It makes each topic only while the
topic has subscribers:
  PREFIX/depth/points                    PointCloud2, coloured while the colour camera runs
  PREFIX/CAMERA/image_rect               world_left, world_center, world_right without distortion
  PREFIX/aligned_depth_to_CAMERA/image_raw, camera_info    depth in the pixels of CAMERA
  PREFIX/CAMERA/image_raw                world, eye and depth images that the headset compresses

examples:
  ml2-receiver products
  ml2-receiver products --name robot1        of a receiver with that name

Arguments after --ros-args go to ROS 2.
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "products",
        help="make point clouds, registered depth, rectified and raw images",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="general.topic_name; default: /magic_leap2"
    )
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    with (
        ros_needed(sends_images=True),
        optional_packages("cv2", command="products", pip="pip install './host_receiver[products]'"),
    ):
        from ..products.node import ProductsNode  # reads the profile
    name = options.name
    prefix = f"/{name}{options.prefix}" if name else options.prefix
    frame_prefix = f"{name}/" if name else ""
    node = ProductsNode(prefix, frame_prefix, node_arguments(options.ros_args, name))
    print(f"ready to make products of {prefix}", flush=True)
    node.spin(stopping)
    return 0
