"""What the screens are made of: pictures in characters, plans, keys, the game as a state machine, the play screen."""
