"""Two checkouts of the project, compared by what their commands print and write; nothing of the package is imported."""
