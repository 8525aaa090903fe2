"""Images as they are looked up, and procedural textures, as the shaders of MaterialX have them."""
