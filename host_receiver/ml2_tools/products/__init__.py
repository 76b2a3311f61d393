"""Images and clouds made on the host from the headset's topics; needs OpenCV.

Only `node` knows ROS. Points and rays are in optical frames, x right, y down, z forward; lengths in
metres, times in ns of ROS time, pixel (0, 0) is the centre of the top left one.
"""
