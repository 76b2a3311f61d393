"""The message types of ROS 2 Jazzy and those of video, as rosbags has them."""

from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from document import ROOT

PACKET = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"
COMPRESSED_VIDEO = "foxglove_msgs/msg/CompressedVideo"


def typestore() -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    for type in (PACKET, COMPRESSED_VIDEO):
        file = ROOT / f"host_receiver/environment/messages/{type}.msg"
        store.register(get_types_from_msg(file.read_text("utf-8"), type))
    return store
