"""What accuracy costs in time: measured runs, lines through their errors, prices, bins against noise."""
