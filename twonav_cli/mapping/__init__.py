"""Occupancy maps, their files, and the maze made from them."""
