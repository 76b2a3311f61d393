"""ml2-receiver products: clouds, registered depth and rectified images."""

import argparse
import os
import sys

from ..errors import ProductsError, RosError
from ..fastdds import apply_default_profile
from .config import Subparsers
from .options import add_name
from .stopping import stop_signal

_EPILOG = """\
Beside a running `ml2-receiver run`, or a bag that is played; each topic is made only while
somebody subscribes to it:
  PREFIX/depth/points                    PointCloud2, coloured while the colour camera runs
  PREFIX/depth/image_rect                depth without distortion
  PREFIX/CAMERA/image_rect               color, world_left, world_center, world_right
  PREFIX/aligned_depth_to_CAMERA/image_raw, camera_info    depth in the pixels of CAMERA

examples:
  ml2-receiver products
  ml2-receiver products --name robot1        of a receiver with that name

Whatever follows --ros-args goes to ROS 2.
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "products",
        help="make point clouds, registered depth and rectified images",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="general.topic_name; default: /magic_leap2"
    )
    add_name(parser)
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help=argparse.SUPPRESS)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    warning = apply_default_profile(os.environ)
    if warning is not None:
        print(f"WARNING: {warning}", file=sys.stderr)
    try:
        from ..products.node import ProductsNode  # reads the profile
    except ModuleNotFoundError as error:
        if error.name == "cv2":
            raise ProductsError(
                "products need OpenCV: apt install python3-opencv,"
                " or pip install 'ml2-receiver[products]'"
            ) from error
        raise RosError(f"{error.name} is missing: source ROS 2 Jazzy") from error
    prefix, frame_prefix, namespace = options.prefix, "", []
    if options.name:
        prefix, frame_prefix = f"/{options.name}{prefix}", f"{options.name}/"
        namespace = ["-r", f"__ns:=/{options.name}"]
    node = ProductsNode(prefix, frame_prefix, ["--ros-args", *options.ros_args, *namespace])
    print(f"ready to make products of {prefix}", flush=True)
    node.spin(stopping)
    return 0
