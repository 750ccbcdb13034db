"""Studies: scenes x clip sets x settings, every combination measured alike.

A *study* is described by a file (:mod:`.plan`). Each combination is a *case*: a pure function of a scene's geometry, a
motion graph and some settings (:mod:`.case`), which any ``concurrent.futures.Executor`` may run; workers need this
package and a folder that they share, and nothing of Blender. What a case came to lies in a small file of its own,
named by a hash of all that it depends on, so that a study that was stopped goes on where it was.
"""
