"""Images as they are looked up, and procedural textures, as the shaders of MaterialX have them.

* `lookup`: texels by address mode and filter, and the errors of hardware in both.
* `hextile`: an image over a grid of hexagonal tiles, each turned and shifted at random.
* `hashing`: the random numbers of a cell; `noise` over them; `flakes` in the cells.

They take coordinates and pixels as arrays; the nodes that have them are in `mrm_mtlx.reference.nodes`.
"""
