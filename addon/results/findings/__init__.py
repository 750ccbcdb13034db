"""What was found out about an embedding, ready to be shown, kept with the scene, drawn and exported.

One file for each question that the panels Evaluation, Tuning and Queries put: a generator that asks the core and
returns a :class:`.finding.Finding`.
"""
