"""The materials of a stage as a document: `reading`, over all the others."""
