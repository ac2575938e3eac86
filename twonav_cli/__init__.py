"""twonav: a robot learns to find its way through an apartment from its own camera."""

__version__ = "0.1.0"
