"""The sink that publishes on Zenoh as ROS 2 nodes with rmw_zenoh do; needs no ROS."""
