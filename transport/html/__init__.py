"""How objects look in a notebook: small HTML tables and pictures, strings made without any other package."""
