"""Hard cases, a file a family: what breaks the naive formula, with its exact value.  `transport verify --hard` runs them."""
