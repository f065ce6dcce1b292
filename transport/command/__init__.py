"""The command line: run, list, verify, effects, bench; tables for people and JSON for machines."""
