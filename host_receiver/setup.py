"""The files that colcon (ament_python) installs; pyproject.toml describes the package."""

from setuptools import setup

setup(
    # Where setuptools 68 and later ones take it; three.js in the page of `view` is under MIT.
    license="Apache-2.0 AND MIT",
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ml2_receiver"]),
        ("share/ml2_receiver", ["package.xml"]),
        ("share/ml2_receiver/launch", ["launch/receiver.launch.py"]),
    ],
)
