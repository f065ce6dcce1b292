"""HTML of objects for notebooks: a table, and where matplotlib is installed a small picture."""
