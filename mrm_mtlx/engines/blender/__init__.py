"""Blender's Python module in a process of its own: what the engines that live in it share.

* `runtime`: the one process of an engine, by which interpreter it is run, and whether it works.
* `process`: the process, and the messages to and from it; `blender_server` is its other end, `keeper` stands between.
* `pictures`: pictures that it has written.
"""
