"""Bodies of media: which regions the surfaces bound, what fills each place, and checks that media fit
together.
"""
