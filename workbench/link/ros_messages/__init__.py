"""The topics of the link as ROS 2 messages, for logs and gateways, without Drake or ROS."""
