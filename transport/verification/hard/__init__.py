"""Hard cases of `transport verify --hard`, one file per family: scenes that break a naive formula."""
