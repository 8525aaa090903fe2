"""Pictures: simple shapes, shaded point by point by the generated shader itself."""
