"""The command line, the play screen and what they print."""
