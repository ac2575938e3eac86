"""How an action can end, as the controller, the stages and the learning loops name it."""

REACHED = "reached"
BLOCKED = "blocked"
TIMED_OUT = "timed-out"
