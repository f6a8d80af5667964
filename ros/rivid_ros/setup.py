"""The ament package of a node; the Python package rivid does the work."""

from setuptools import setup

NAME = "rivid_ros"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[("share/ament_index/resource_index/packages", [f"resource/{NAME}"]), (f"share/{NAME}", ["package.xml"])],
    install_requires=["setuptools", "rivid"],
    entry_points={"console_scripts": [f"play = {NAME}.play:main"]},
)
