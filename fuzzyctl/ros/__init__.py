"""ROS 2: a node that runs a controller of a rule file, its signals in messages of any type."""
