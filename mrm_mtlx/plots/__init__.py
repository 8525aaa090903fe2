"""Plots of lobes: their data, in NumPy, and their drawing, with matplotlib.

* `curves`: the value of a lobe against the view angle; `parameters` makes lobes of a few numbers, `documents` evaluates
  the surfaces of a document.
* `paper`: the data of the figures of Portsmouth et al. 2026 that need no path tracer.
* `coefficients`: R_A and the like against the observation and the entrance angle, with the minima of a class.
* `drawing`, `coefficients_drawing`: pictures of these data, with `style`. Nothing else here imports matplotlib.

In plots of lobes the light is in the plane of incidence at theta_l >= 0, and a view angle theta_v is positive on the
side of the light: a retroreflective lobe has its peak at theta_v = theta_l, an ordinary one at theta_v = -theta_l.
"""
