"""The files that colcon (ament_python) installs; pyproject.toml describes the package."""

from setuptools import setup

setup(
    # setuptools 68 reads no licence expression from pyproject.toml. The page of `view` has three.js, under MIT.
    license="Apache-2.0 AND MIT",
    python_requires=">=3.12",  # colcon cannot read what setuptools makes of it in pyproject.toml
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ml2_receiver"]),
        ("share/ml2_receiver", ["package.xml"]),
        ("share/ml2_receiver/launch", ["launch/receiver.launch.py"]),
    ],
)
