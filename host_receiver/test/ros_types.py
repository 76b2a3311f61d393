"""The message types of ROS 2 Jazzy and of ffmpeg_image_transport_msgs, as rosbags has them."""

from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from document import ROOT

PACKET = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"


def typestore() -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    file = ROOT / f"host_receiver/environment/messages/{PACKET}.msg"
    store.register(get_types_from_msg(file.read_text("utf-8"), PACKET))
    return store
