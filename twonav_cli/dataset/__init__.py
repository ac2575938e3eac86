"""Camera frames with poses: where to take them, and how they are stored."""
