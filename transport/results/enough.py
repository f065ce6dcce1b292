"""How many scores are enough to know an error bar: the one number for it."""

# Fewer scores than this are too few, wherever the question arises: the mean of 25 scores of one size has a skewness of
# 25^-1/2 = 0.2, by which a 95 % interval covers 1 % less than it claims (Hall 1988, equation 2.5).
MIN_SCORES = 25
