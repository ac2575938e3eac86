"""The paper's tables and figures about learning in the maze, made again: one module each."""
