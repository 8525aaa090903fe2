"""A document, however it is stored: where it comes from, its files and images, its elements and their connections.

* `document`: what reading a file gives. `files`: the folders that its names of files may lead to.
* `locations`, over `xml_elements` and `text_positions`: where an element stands in its file; `xml_scan` looks at that
  file before MaterialX reads it.
* `images`: decoding and encoding of image files, and their size limits; `document_images`: those of a document in
  memory, and the limit on them; `image_checks`: findings about them.
* `elements`, `graph`, `interfaces`, `constants`, `filenames`: inputs, what gives their values, and names among them.
* `flattening`: graphs of nodes in the place of nodes, within a limit.
"""
