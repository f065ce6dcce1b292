"""How many scores are enough to know an error bar."""

MIN_SCORES = 25  # a mean of 25 like scores has a skewness of 0.2, which costs a 95 % interval 1 % (Hall 1988)
