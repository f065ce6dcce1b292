"""`transport effects`: the passes that a scene needs, their cost, and compile times."""
