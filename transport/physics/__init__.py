"""Physical laws as device functions of scalars, one process per file; loops over particles are in engine/."""
