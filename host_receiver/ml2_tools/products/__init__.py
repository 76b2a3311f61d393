"""Computes images and point clouds on the host from the headset's topics; needs OpenCV.

Points and rays are in optical frames: x right, y down, z forward. Lengths are in metres, times in
ns of ROS time. Pixel coordinate (0, 0) is the centre of the top left pixel.
"""
