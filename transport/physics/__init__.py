"""Physical laws as device functions of scalars, one process a file; loops over particles live in engine/."""
