"""What hosts draw with the library that was installed for them: a picture, and the shaders that they made for it."""
