"""MaterialX's own XML."""
