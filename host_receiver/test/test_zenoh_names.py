"""The strings of rmw_zenoh, as its sources and design.md have them, and as another program."""

import pytest
from zenoh_ros2_sdk.attachment import Attachment
from zenoh_ros2_sdk.entity import EndpointEntity, EntityKind, NodeEntity
from zenoh_ros2_sdk.keyexpr import (
    endpoint_liveliness_keyexpr,
    node_liveliness_keyexpr,
    topic_keyexpr,
)
from zenoh_ros2_sdk.qos import QosDurability, QosProfile

from ml2_receiver.errors import PublishError
from ml2_receiver.table.stream_table import Qos
from ml2_receiver.zenoh.names import Node, TopicName, attachment, gid

IMU_HASH = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
TF_HASH = "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
IMU = TopicName("/magic_leap2/gyro_left/imu", "sensor_msgs/msg/Imu", Qos(200))
STATIC = TopicName("/tf_static", "tf2_msgs/msg/TFMessage", Qos(1, "transient_local"))
NODE = Node(7, "8f3a01", "robot1")


def test_a_key_has_domain_name_type_and_hash() -> None:
    assert IMU.key(0) == f"0/magic_leap2/gyro_left/imu/sensor_msgs::msg::dds_::Imu_/{IMU_HASH}"
    assert STATIC.key(12) == f"12/tf_static/tf2_msgs::msg::dds_::TFMessage_/{TF_HASH}"


def test_tokens_have_the_session_the_namespace_and_the_qos() -> None:
    assert NODE.token() == "@ros2_lv/7/8f3a01/0/0/NN/%/%robot1/ml2_receiver"
    assert Node(0, "a", "").token() == "@ros2_lv/0/a/0/0/NN/%/%/ml2_receiver"
    assert NODE.publisher_token(3, IMU) == (
        "@ros2_lv/7/8f3a01/0/3/MP/%/%robot1/ml2_receiver/%magic_leap2%gyro_left%imu"
        f"/sensor_msgs::msg::dds_::Imu_/{IMU_HASH}/::,200:,:,:,,"
    )
    assert NODE.publisher_token(4, STATIC) == (
        "@ros2_lv/7/8f3a01/0/4/MP/%/%robot1/ml2_receiver/%tf_static"
        f"/tf2_msgs::msg::dds_::TFMessage_/{TF_HASH}/:1:,1:,:,:,,"
    )


def test_the_default_depth_is_left_out() -> None:
    battery = TopicName("/b", "sensor_msgs/msg/BatteryState", Qos(42))
    assert NODE.publisher_token(1, battery).endswith("/::,:,:,:,,")


def test_an_attachment_has_33_bytes() -> None:
    made = attachment(1, 0x0102030405060708, bytes(range(16)))
    assert made.hex() == "0100000000000000080706050403020110" + bytes(range(16)).hex()


def test_another_program_makes_the_same_strings() -> None:
    node = NodeEntity(7, "8f3a01", 0, "ml2_receiver", "/robot1")
    assert NODE.token() == node_liveliness_keyexpr(node)
    for topic, qos in (
        (IMU, QosProfile(history_depth=200)),
        (STATIC, QosProfile(history_depth=1, durability=QosDurability.TRANSIENT_LOCAL)),
    ):
        dds, hashed = topic.key(7).split("/")[-2:]
        kind = EntityKind.PUBLISHER
        theirs = EndpointEntity(node, 5, kind, topic.name, dds, hashed, qos.encode())
        assert NODE.publisher_token(5, topic) == endpoint_liveliness_keyexpr(theirs)
        assert topic.key(7) == topic_keyexpr(7, topic.name, dds, hashed)
    read = Attachment.from_bytes(attachment(9, 10, gid("token")))
    assert (read.sequence_id, read.timestamp_ns, read.gid) == (9, 10, gid("token"))


def test_a_gid_is_that_of_the_graph() -> None:
    # simplified_XXH3_128bits() of rmw_zenoh_cpp, compiled on its own, gave these bytes in memory:
    # low64, then high64. The tokens are those of the tests above.
    assert gid(NODE.publisher_token(3, IMU)).hex() == "a29f7926e4b821c94d1c58851ed937d4"
    assert gid(NODE.publisher_token(4, STATIC)).hex() == "4b7fbe3faa3430d073117a27980aa374"
    # And xxHash's own vector of no bytes: low 6001c324468d497f, high 99aa06d3014798d8.
    assert gid("").hex() == "7f498d4624c30160d8984701d306aa99"


def test_a_type_without_a_known_hash_is_refused() -> None:
    with pytest.raises(PublishError, match="found my_msgs/msg/Mine"):
        TopicName("/custom/mine", "my_msgs/msg/Mine", Qos(10))
