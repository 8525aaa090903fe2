"""The system below: processes, files and text, and the limits that keep untrusted input from harming it.

* `limits`: size limits of what is read.
* `process_limits`: what a process binds itself to: memory, time, and not to outlive who started it.
* `console`: what C++ libraries print.
* `writing`: files written whole or not at all.
* `plugins`: what other packages register.
* `text`: untrusted text as it is shown.
"""
