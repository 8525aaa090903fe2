"""File formats of materials: what of a document each can say, and what it says of one.

* `registry`: the one table of formats, with those of other packages. `format` is what each of them is, and `options`
  what it may declare for `mrm convert`.
* `reading`: an untrusted file of any format as a `documents.document.Document`: the one door.
* `materialx`, `usd`, `gltf`: read and written. `openmaterial`: a coefficient of retroreflection, written, compared, and
  fitted to.
* `pbr`: a surface as formats that read less have it, exactly or nearly; and how far two are apart.
* `files`: image files that are copied beside what is written; `json_text`, `json_positions`: untrusted JSON.

Formats lie above `reference` and `photometry`: glTF, OpenMATERIAL and USD's look by day say values of surfaces, which
are evaluated.
"""
