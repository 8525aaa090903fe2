"""A document, however it is stored: where it comes from, its files and images, its elements and their connections."""
