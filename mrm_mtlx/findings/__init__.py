"""The vocabulary of everything that reports: findings, and the rules that they are cases of."""
