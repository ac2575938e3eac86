"""Multi-goal Q-learning: needs neither MuJoCo nor torch."""
