"""Statistics of batches: means, standard errors, estimates with units, findings, pooled errors. No scenes."""
