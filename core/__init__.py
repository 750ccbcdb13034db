"""Wayfarer's core: motion graphs, their embedding into a scene, evaluation and playback.

NumPy and SciPy only; nothing in here knows Blender. The data flows one way::

    clips -> MotionGraph -.
    obstacles, regions -> Environment -> Embedding -> variability, coverage, ...
                                                  '-> Walk -> poses

Conventions, stated once for the whole package:

* Metres, seconds and radians. A unit stands in a name only where it differs.
* Z is up; the ground plane is XY. *Heading* is the angle of the character's forward direction from +X,
  counter-clockwise seen from above.
* Quaternions are unit length, ordered (w, x, y, z).
* Arrays are time-first: (F, J, 3) is frames x joints x components.
* Grid arrays are indexed [x, y, heading] and, where segments matter, [x, y, heading, segment].
* A clip's joint 0 is its root, given in world space; every other joint is relative to its parent.
* *Links* join segments (transitions) or grid states; the word *edge* is kept for meshes.
* Every function is pure: values in, new values out. Randomness enters as ``rng: numpy.random.Generator``.
* Long work is a generator ``..._steps(...)`` that yields :class:`core.progress.Progress` and returns its
  result; ``core.progress.finish`` drains it.

Source of the definitions: P. S. A. Reitsma and N. S. Pollard, "Evaluating and Tuning Motion Graphs for
Character Animation", Brown University CS-04-04, 2004 ("the paper"); transition costs after J. Lee, J. Chai,
P. S. A. Reitsma, J. K. Hodgins and N. S. Pollard, "Interactive Control of Avatars Animated with Human Motion
Data", SIGGRAPH 2002 ("Lee et al. 2002").
"""
