"""The pose from one image: the one place that imports torch."""
