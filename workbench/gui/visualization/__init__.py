"""The Visualization screen: charts, lidar, camera, frames, events, and logs."""
