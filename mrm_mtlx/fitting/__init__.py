"""Materials that fit measurements, or meet the minima of a class."""
