"""Nodes of ROS 2 for rivid."""
