"""The worlds an agent can learn in, behind one protocol."""
