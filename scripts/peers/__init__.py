"""weavesim compared with Newton's cloth solvers on one drape: a square of fabric falls onto a ball.

    python scripts/benchmark.py peers --newton-python newton-environment/bin/python

Each contestant runs alone in a separate process on one CPU thread, or on the given device. All get the same nodes,
masses, initial velocity, gravity, air drag, ball and simulated time. A quadrilateral of weavesim is two triangles in
Newton. Self-contact is off in all, weavesim's too, but for XPBD, which requires it: it has contact between beads on the
nodes, as thick as the fabric.

Settings of Newton's solvers follow its example ``cloth_hanging``, which runs VBD, XPBD and SemiImplicit, and for
Style3D ``cloth_style3d``, whose garment has a realistic mass: iterations, time step (ten steps per sixtieth of a
second), collision detection in every step (``cloth_style3d``: every tenth), steps recorded as a graph wherever the
example does so. Exceptions:

- Explicit SemiImplicit uses 0.9 of its stable step, as weavesim does, instead of the example's fixed 1/1920 s.
- XPBD diverges with the example's step, as nodes weigh less than a thousandth of the example's. It runs a second time
  with the explicit step and the solver's default of two iterations. VBD runs a second time with five times the
  iterations.
- Contact stiffness is Newton's default, 1 kN/m. Damping and friction slope of SemiImplicit's contact follow from it,
  the nodal mass and the step, as the defaults are made for heavier particles.
- No internal damping, as in weavesim; numerical dissipation of a solver's time integration remains.

Materials: Style3D and XPBD (springs along the yarns and both diagonals) take the fabric's stiffness along the yarns and
in shear. The triangles of VBD and SemiImplicit are isotropic: they get the yarns' stiffness with a Poisson ratio of 0,
and so half of it in shear, far too much for a weave. Bending is set hinge by hinge so that a cylinder along
either yarn has the fabric's bending stiffness; in a right-angled grid this is one third of Style3D's own scale.
"""
