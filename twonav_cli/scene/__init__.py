"""Scenes, the robot in them and its sensors: the one place that imports MuJoCo."""
