"""Generated code beside the reference: what is drawn, what is expected, and how far both are apart.

* `sampling`: where a surface is looked at; `expectation`: what the reference says there.
* `samples`: a program over samples, and the comparison of what it gives; `drawing`: a shader in an engine that draws,
  `closures`: one in an engine that measures what closures reflect.
* `mending`, `document_mends`: shaders and documents in which a known deviation of MaterialX does not show.
"""
