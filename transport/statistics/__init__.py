"""Statistics of batches: means, standard errors, estimates with units, findings, pooled errors. Knows no scene."""
