"""Our topics as messages of ROS 2, for logs and gateways; neither Drake nor ROS is needed."""
