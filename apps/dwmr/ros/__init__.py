"""ROS 2: a node that drives a formation by the control laws of scenarios."""
