"""Starts the receiver: ros2 launch ml2_receiver receiver.launch.py listen:=0.0.0.0:7755"""

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.launch_context import LaunchContext
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "config", default_value="", description="config.yaml; empty: as `ml2-receiver run`"
            ),
            DeclareLaunchArgument(
                "name", default_value="", description="of the headset, as `ml2-receiver run --name`"
            ),
            DeclareLaunchArgument(
                "namespace",
                default_value="",
                description="as `name`",
            ),
            DeclareLaunchArgument(
                "listen", default_value="", description="HOST:PORT; empty: as `ml2-receiver run`"
            ),
            OpaqueFunction(function=_receiver),
        ]
    )


def _receiver(context: LaunchContext) -> list[Node]:
    arguments = {
        name: LaunchConfiguration(name).perform(context)
        for name in ("config", "name", "namespace", "listen")
    }
    given = [
        word
        for option in ("config", "name", "listen")
        if arguments[option]
        for word in (f"--{option}", arguments[option])
    ]
    return [
        Node(
            package="ml2_receiver",
            executable="ml2-receiver",
            namespace=arguments["namespace"],
            arguments=["run", *given],
            output="screen",
        )
    ]
