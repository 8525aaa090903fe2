"""What builds the Blender extension: `python -m tools.blender_extension -o DIR`.

* `archive`: the zip, the same bytes for the same sources.
* `contents`: its files, by name.
* `materials`: a ready material as the extension wants it, with `networks` for USD.
* `previews`: the pictures of the asset browser.
"""
