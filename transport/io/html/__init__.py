"""HTML of objects for notebooks: small tables and pictures, built as strings without other packages."""
