"""Grounds too large for one process: embedded in parcels, by as many workers as there are.

A *parcel* is a rectangle of cells; its worker also knows a halo around it, as wide as the longest one-step path. Sets
of nodes lie in files, one for each parcel, in a folder that all workers share; tasks read them, work on one parcel, and
write new ones, never changing what is there. A task may therefore be run again whenever a worker is lost.

Work is handed to any ``concurrent.futures.Executor``: a process pool, Dask's, or none at all. The result is the same as
that of :func:`core.embedding.embedding.embed`, to the last node and link.
"""
