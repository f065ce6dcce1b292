"""Bodies of media: the regions that surfaces bound, what fills each place, and checks that media fit."""
