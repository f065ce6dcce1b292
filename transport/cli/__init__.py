"""The command line `transport`: commands, their options, and output as tables or JSON."""
