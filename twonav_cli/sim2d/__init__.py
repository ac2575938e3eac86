"""The 2D simulator: the robot's footprint on the map, without physics and pictures, compiled (§3.1.3)."""
