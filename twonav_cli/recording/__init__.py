"""Events into a Rerun recording and back: the one place that imports rerun."""
