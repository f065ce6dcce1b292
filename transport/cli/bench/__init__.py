"""`transport bench`: rates of the engine against straightforward kernels on the same machine."""
