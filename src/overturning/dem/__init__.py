"""The distinct element method: scene, contact law, time step, kernels."""
