"""Cost of accuracy in time: measured runs, fits of error against seconds, prices, bins against noise."""
