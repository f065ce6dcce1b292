"""Run a program: settings, schedules of batches, stopping rules, thread executor, memory check, progress."""
