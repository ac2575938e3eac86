"""Pictures of the tables and figures: the one place that imports matplotlib."""
