"""A scene as text: JSON that holds all of it bit by bit, can be written by hand, and runs without Python code."""
