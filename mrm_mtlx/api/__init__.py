"""The commands as functions: the modules behind the names of `mrm_mtlx`, one per verb.

A function takes what its command takes, as keywords of the same names with the same defaults, and returns plain data
that show themselves. Nothing heavy is imported before a function is called. What is wrong is an exception: an
`ArgumentError` (a ValueError) for a wrong call, an `MrmError` for the rest (`errors`).
"""
