"""The materials of a document as a stage: `saving`, over `writing` and `scope`."""
