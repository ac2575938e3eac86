"""Tables 9 and 10: agents that go from the maze through 2D into 3D, and agents that learn in 3D from nothing."""
