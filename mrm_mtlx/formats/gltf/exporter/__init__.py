"""A document as a glTF asset: `writing`, over all the others."""
