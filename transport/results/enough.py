"""The number of scores that is enough to know an error bar, defined once."""

# Fewer scores are too few everywhere: the mean of 25 scores of one size has a skewness of 25^-1/2 = 0.2, with
# which a
# 95 % interval covers 1 % less than it claims (Hall 1988, equation 2.5).
MIN_SCORES = 25
