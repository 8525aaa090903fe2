"""The system below: processes, files and text, and the limits that keep untrusted input from harming it.

* `versions`: this package's version, and those of what a verdict depends on.
* `arguments`: wrong arguments, and what is said of them; `shown`: results that show themselves.
* `limits`: size limits of what is read.
* `process_limits`: what a process binds itself to: memory, time, and not to outlive who started it.
* `child`, `spawning`: a command's process, and how worker processes are started.
* `console`: what C++ libraries print.
* `writing`: files written whole or not at all.
* `plugins`: what other packages register.
* `json_data`: data of reports as JSON can hold them; `text`: untrusted text as it is shown.
"""
