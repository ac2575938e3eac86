"""From one cell to the next: cost map, shortest paths, dynamic window, cell driver."""
