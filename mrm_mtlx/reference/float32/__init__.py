"""The error theory of float32: how an evaluation is perturbed, and how far off its delicate quantities may be.

* `rounding`: the perturbations of an evaluation by roundings, and the tolerance that they make.
* `precision`: errors of quantities that cancel and of built-in functions, by the precisions that GLSL and Vulkan state;
  `widened` gives a result all that such errors may add to it.
* `function_errors`: the same for the functions of nodes.
* `intermediates`: the delicate intermediate results of `mrm_mtlx.bsdf`, as far off as float32 may have them.

`precision` and `intermediates` know the optics, `rounding` nothing but numbers.
"""
