"""A glTF asset as a document: `reading`, over `container`, `textures` and `graph`."""
