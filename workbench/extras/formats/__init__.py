"""SDF, MJCF and Gazebo worlds, and rotors as gym-pybullet-drones and MuJoCo write them."""
