"""The loops: learning trials, evaluation, playing."""
